// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// `reconstruct stereo` in a car, through images that are rendered and matched: seat and head against the simulator's
// truth, the advised exposure, videos, and what is said of bad input.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "program.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;

constexpr int kSize_px = 320;

// A cabin that was simulated, and what whoever installs its sensor knows.
struct Cabin {
  fs::path folder;
  nlohmann::json scene;

  explicit Cabin(const std::string& seat_class, int frames) : folder(fresh_folder()) {
    const ProgramRun run = raybundle_program(
        {"simulate-cockpit", "--sensor", "stereo", "--class", seat_class, "--scenes", "1", "--frames",
         std::to_string(frames), "--size", std::to_string(kSize_px), "--seed", "21", "-o", (folder / "sim").string()});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    const nlohmann::json index = json_of(folder / "sim" / "scenes.json");
    scene = index.at("scenes").at(0);
    const nlohmann::json& car = scene.at("vehicle");
    std::string toml = "[vehicle]\ndashboard_top_m = 0.46\n";
    for (const char* key : {"dashboard_x_m", "zone_floor_m", "zone_half_width_m", "critical_m", "out_of_position_m"}) {
      toml += fmt::format("{} = {}\n", key, car.at(key).dump());
    }
    const nlohmann::json& pose = index.at("vehicle_from_rig");
    toml += fmt::format("[stereo]\nrotation_xyzw = {}\ntranslation_m = {}\n", pose.at("rotation_xyzw").dump(),
                        pose.at("translation_m").dump());
    write_text(folder / "vehicle.toml", toml);
  }
  fs::path image(int frame, const char* side) const {
    return folder / "sim" / fmt::format("00000_{:03}_{}.png", frame, side);
  }
  ProgramRun reconstruct(const std::string& left, const std::string& right, std::vector<std::string> more = {}) const {
    std::vector<std::string> words{"reconstruct",
                                   "stereo",
                                   (folder / "sim" / "calibration.json").string(),
                                   left,
                                   right,
                                   "-o",
                                   (folder / "out").string(),
                                   "--near",
                                   "0.3",
                                   "--field",
                                   "110",
                                   "110",
                                   "--width",
                                   std::to_string(kSize_px),
                                   "--height",
                                   std::to_string(kSize_px)};
    words.insert(words.end(), more.begin(), more.end());
    return raybundle_program(words);
  }
  ProgramRun reconstruct_all(std::vector<std::string> more = {}) const {
    const fs::path images = folder / "sim";
    return reconstruct((images / "*_left.png").string(), (images / "*_right.png").string(), std::move(more));
  }
};

double distance(const nlohmann::json& a, const nlohmann::json& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::pow(a.at(i).get<double>() - b.at(i).get<double>(), 2);
  return std::sqrt(sum);
}

// 25 mm: what one frame of an unknown head at 0.7 m allows; the bar over many is that of `prove head`.
TEST(StereoInACar, TellsTheHead) {
  const Cabin cabin("passenger", 1);
  const ProgramRun run =
      cabin.reconstruct(cabin.image(0, "left").string(), cabin.image(0, "right").string(),
                        {"--json", "--vehicle", (cabin.folder / "vehicle.toml").string(), "--exposure", "8", "1"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json told = nlohmann::json::parse(run.out);
  const nlohmann::json& head = told.at("cabin").at("head");
  ASSERT_TRUE(head.is_object());
  EXPECT_LT(distance(head.at("centre_m"), cabin.scene.at("frames").at(0).at("truth").at("head").at("centre_m")), 0.025);
  EXPECT_GT(head.at("sigma_m").at(0), 0.0);
  EXPECT_TRUE(told.at("cabin").at("seat").is_null());  // somebody hides it
  EXPECT_GT(told.at("cabin").at("boxes").at("body").at("hits"), 100);
  EXPECT_GT(told.at("exposure").at("next").at("shutter_ms"), 0.0);
  EXPECT_NE(text_of(cabin.folder / "out" / "stereo.html").find("\"drawn\""), std::string::npos);
}

// Two centimetres in a mean of four frames; sixteen reach one.
TEST(StereoInACar, TellsAnEmptySeat) {
  const Cabin cabin("empty", 4);
  const ProgramRun run = cabin.reconstruct_all({"--vehicle", (cabin.folder / "vehicle.toml").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json last = json_of(cabin.folder / "out" / "3.json").at("cabin");
  ASSERT_TRUE(last.at("seat").is_object());
  EXPECT_TRUE(last.at("head").is_null());
  const nlohmann::json truth = cabin.scene.at("frames").at(0).at("truth").at("seat").at("bight_m");
  EXPECT_LT(distance(last.at("seat").at("bight_m"), {truth.at(0), truth.at(2)}), 0.02);
}

// A video of the images, losslessly coded, gives the same points as they do.
TEST(ReconstructStereo, TakesVideos) {
  const Cabin cabin("passenger", 3);
  for (const char* side : {"left", "right"}) {
    cv::VideoWriter video((cabin.folder / side).string() + ".avi", cv::VideoWriter::fourcc('F', 'F', 'V', '1'), 10.0,
                          {kSize_px, kSize_px}, false);
    if (!video.isOpened()) GTEST_SKIP() << "OpenCV of this machine cannot write FFV1 videos";
    for (int frame = 0; frame < 3; ++frame) {
      video.write(cv::imread(cabin.image(frame, side).string(), cv::IMREAD_GRAYSCALE));
    }
  }
  ASSERT_EQ(cabin.reconstruct_all().exit_code, 0);
  const auto points = [&](const std::string& name) -> int {
    return json_of(cabin.folder / "out" / (name + ".json")).at("points");
  };
  const int of_images[] = {points("0"), points("1"), points("2")};
  const ProgramRun run = cabin.reconstruct((cabin.folder / "left.avi").string(), (cabin.folder / "right.avi").string());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (int frame = 0; frame < 3; ++frame) {
    const int of_image = of_images[frame], of_video = points(fmt::format("{:06}", frame));
    EXPECT_NEAR(of_video, of_image, 0.02 * of_image) << frame;  // grey may be rounded otherwise by one
  }
}

TEST(StereoInACar, SaysWhatIsWrongWithTheVehicle) {
  const Cabin cabin("passenger", 1);
  const std::string good = text_of(cabin.folder / "vehicle.toml");
  const auto run_with = [&](const std::string& toml) {
    write_text(cabin.folder / "bad.toml", toml);
    return cabin.reconstruct(cabin.image(0, "left").string(), cabin.image(0, "right").string(),
                             {"--vehicle", (cabin.folder / "bad.toml").string()});
  };
  const std::pair<std::string, std::string> cases[] = {
      {good.substr(0, good.find("[stereo]")), "has no section [stereo]"},
      {"= 3", "is not TOML"},
      {good + "tilt = 3\n", "unknown field 'tilt'"},
      {good + "[[fixtures]]\n", "unknown field 'fixtures'"},
      {good.substr(0, good.find("critical_m")) + "[stereo]\n", "needs a field 'critical_m'"}};
  for (const auto& [toml, said] : cases) {
    const ProgramRun run = run_with(toml);
    EXPECT_EQ(run.exit_code, 2) << toml;
    EXPECT_NE(run.err.find(said), std::string::npos) << run.err;
    EXPECT_NE(run.err.find("bad.toml"), std::string::npos) << run.err;
  }
  EXPECT_EQ(cabin.reconstruct_all({"--vehicle", "none.toml"}).exit_code, 5);
  EXPECT_EQ(cabin.reconstruct_all({"--exposure", "0", "1"}).exit_code, 2);
}

}  // namespace
}  // namespace raybundle::testing
