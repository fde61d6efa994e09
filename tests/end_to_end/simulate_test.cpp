// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "program.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;

std::string rig_file(const std::string& name) { return RAYBUNDLE_SOURCE_DIR "/datasets/rigs/" + name + ".toml"; }

void simulate(const fs::path& folder, const std::string& rig, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"simulate", rig, "-o", folder.string()});
  const ProgramRun run = raybundle_program(arguments);
  ASSERT_EQ(run.exit_code, 0) << run.err;
}

// The images of a stereo head give back the head: its baseline is known to a part of the accuracy of corners, 0.05 px
// over 12 views, at 0.3 m.
TEST(Simulate, ImagesGiveTheRigBack) {
  const fs::path folder = fresh_folder();
  simulate(folder / "sim", rig_file("rig_21mm_stereo"), {"--frames", "12", "--seed", "5"});
  const nlohmann::json report = calibrate(folder, {(folder / "sim" / "dataset.toml").string()});
  const nlohmann::json calibration = json_of(folder / "out" / "calibration.json");
  const nlohmann::json truth = json_of(folder / "sim" / "truth" / "calibration.json");
  EXPECT_LT(report["rms_px"].get<double>(), 0.15);
  EXPECT_NEAR(baseline_m(calibration, "left", "right"), baseline_m(truth, "left", "right"), 2e-4);
  for (const char* camera : {"left", "right"}) {
    const double fx = camera_in(truth, camera)["parameters"]["fx"];
    EXPECT_NEAR(camera_in(calibration, camera)["parameters"]["fx"].get<double>(), fx, 2e-3 * fx);
    EXPECT_GE(camera_in(report, camera)["views_used"].get<int>(), 8);
  }
}

TEST(Simulate, WritesPairsOfImagesThatDoNotDependOnThreads) {
  const fs::path folder = fresh_folder();
  const std::string rig = rig_file("rig_26mm_laser");
  simulate(folder / "one", rig, {"--frames", "3", "--seed", "7", "--threads", "1", "--beams", "19x16"});
  simulate(folder / "two", rig, {"--frames", "3", "--seed", "7", "--threads", "2", "--beams", "19x16"});
  for (const char* name : {"000_off.png", "000_on.png", "002_off.png", "002_on.png"}) {
    const std::string bytes = text_of(folder / "one" / "images" / "camera" / name);
    EXPECT_FALSE(bytes.empty()) << name;
    EXPECT_EQ(bytes, text_of(folder / "two" / "images" / "camera" / name)) << name;
  }
  const std::string dataset = text_of(folder / "one" / "dataset.toml");
  EXPECT_NE(dataset.find("grid = \"19x16\""), std::string::npos);
  EXPECT_NE(dataset.find("laser_on = \"images/camera/*_on.png\""), std::string::npos);
  EXPECT_EQ(json_of(folder / "one" / "observations.json")["views"][0]["image"], "images/camera/000_off.png");
  simulate(folder / "one", rig, {"--frames", "2", "--seed", "7"});
  EXPECT_FALSE(fs::exists(folder / "one" / "images" / "camera" / "002_off.png")) << "of the earlier run";
  simulate(folder / "one", rig, {"--frames", "2", "--seed", "8", "--no-images"});
  EXPECT_FALSE(fs::exists(folder / "one" / "images" / "camera" / "000_off.png")) << "of another truth";
  EXPECT_FALSE(fs::exists(folder / "one" / "dataset.toml")) << "which names images";
}

TEST(Simulate, TwelveBitsFillThoseOfAPng) {
  const fs::path folder = fresh_folder();
  std::string rig = text_of(rig_file("rig_26mm_laser"));
  rig.replace(rig.find("full_well_e"), 0, "bits = 12\nexposure = 50\n");
  write_text(folder / "rig.toml", rig);
  simulate(folder / "sim", (folder / "rig.toml").string(), {"--frames", "1"});
  const cv::Mat image = cv::imread((folder / "sim/images/camera/000_on.png").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(image.type(), CV_16U);
  double largest = 0;
  cv::minMaxLoc(image, nullptr, &largest);
  EXPECT_EQ(largest, 65535);
}

TEST(Simulate, NoImagesWithoutAPrint) {
  const fs::path folder = fresh_folder();
  std::string rig = text_of(rig_file("rig_21mm_stereo"));
  const std::size_t target = rig.find("kind = \"chessboard\""), end = rig.find("[board]");
  rig.replace(target, end - target, "kind = \"points\"\nfile = \"points.csv\"\n\n");
  write_text(folder / "rig.toml", rig);
  write_text(folder / "points.csv",
             "0,0,0,0\n1,0.1,0,0\n2,0.1,0.1,0\n3,0,0.1,0\n4,0.05,0.05,0\n5,0.02,0.05,0\n"
             "6,0.05,0.02,0\n7,0.08,0.05,0\n8,0.08,0.08,0\n");
  simulate(folder / "sim", rig_file("rig_21mm_stereo"), {"--frames", "1"});
  const std::string former = text_of(folder / "sim/observations.json");
  const ProgramRun run =
      raybundle_program({"simulate", (folder / "rig.toml").string(), "-o", (folder / "sim").string()});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("--no-images"), std::string::npos) << run.err;
  EXPECT_EQ(text_of(folder / "sim/observations.json"), former);  // nothing of the run before is touched
  EXPECT_TRUE(fs::exists(folder / "sim/dataset.toml"));
}

}  // namespace
}  // namespace raybundle::testing
