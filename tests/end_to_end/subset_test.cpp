// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <map>

#include "program.hpp"
#include "synthetic_world.hpp"
#include "tables.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;
constexpr const char* kStereo = "opencv_stereo_chess";

std::vector<std::string> stereo_images(const char* left, const char* right) {
  return {"--target", "chessboard:9x6:25mm",
          "--camera", "left=" + (real_data(kStereo) / left).string(),
          "--camera", "right=" + (real_data(kStereo) / right).string()};
}

std::vector<std::string> with(std::vector<std::string> arguments, const std::vector<std::string>& more) {
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

const std::vector<std::string> kBrown{"--model", "brown_conrady"};

class Subsets : public ::testing::Test {
 protected:
  void SetUp() override { RAYBUNDLE_NEEDS_DATA(kStereo); }

  fs::path place = fresh_folder();
  std::vector<std::string> all = stereo_images("left*.jpg", "right*.jpg");
  nlohmann::json calibration() const { return json_of(place / "out" / "calibration.json"); }
};

TEST_F(Subsets, EachCameraHasItsOwnModel) {
  const auto report = calibrate(place, with(all, {"--model", "left=kannala_brandt", "--model", "right=rational"}));
  ASSERT_TRUE(report.contains("cameras"));
  EXPECT_EQ(camera_in(calibration(), "left").at("model"), "kannala_brandt");
  EXPECT_EQ(camera_in(calibration(), "right").at("model"), "rational");
  EXPECT_LE(camera_in(report, "left").at("rms_px"), 0.26);
  EXPECT_LE(camera_in(report, "right").at("rms_px"), 0.26);
}

// Moved by hand, the right camera's place is found again, and no intrinsic changes a bit.
TEST_F(Subsets, ExtrinsicsOnlyFromAnEarlierCalibration) {
  calibrate(place, with(all, kBrown));
  const nlohmann::json before = calibration();
  const fs::path again = fresh_folder() / "again";
  fs::create_directories(again);
  write_text(again / "start.json", before.dump());
  calibrate(again, with(all, {"--model", "brown_conrady", "--start", (again / "start.json").string(), "--fix",
                              "*.intrinsics"}));
  const nlohmann::json after = json_of(again / "out" / "calibration.json");
  for (const char* name : {"left", "right"}) {
    EXPECT_EQ(camera_in(before, name).at("parameters"), camera_in(after, name).at("parameters"));
  }
  // The first solve's corners differ by those that only its lens could predict.
  EXPECT_NEAR(baseline_m(after, "left", "right"), baseline_m(before, "left", "right"), 1e-4);
  EXPECT_FALSE(camera_in(after, "left").at("sigmas").contains("fx")) << "a fixed parameter has no sigma";
}

// A rig frame is that of the first camera, which need not be the first of the start: left on top of right was the
// answer once.
TEST_F(Subsets, KeptExtrinsicsAreThoseOfTheStartWhicheverCameraComesFirst) {
  calibrate(place, with(all, kBrown));
  const fs::path again = fresh_folder() / "again";
  fs::create_directories(again);
  write_text(again / "start.json", calibration().dump());
  const std::vector<std::string> swapped{all[0], all[1], all[4], all[5], all[2], all[3]};
  calibrate(again, with(swapped, {"--model", "brown_conrady", "--start", (again / "start.json").string(), "--fix",
                                  "*.camera_from_rig"}));
  const nlohmann::json after = json_of(again / "out" / "calibration.json");
  ASSERT_EQ(after.at("cameras")[0].at("name"), "right");
  EXPECT_NEAR(baseline_m(after, "left", "right"), baseline_m(calibration(), "left", "right"), 1e-9);
  const auto rms_px = [](const nlohmann::json& of) {
    return camera_in(of, "left").at("residuals").at("rms_px").get<double>();
  };
  EXPECT_NEAR(rms_px(after), rms_px(calibration()), 0.01);
}

// A camera that comes to a rig which is known.
TEST_F(Subsets, ACameraThatTheStartDoesNotHaveStartsFromItsImages) {
  const std::vector<std::string> left_alone{all[0], all[1], all[2], all[3]};
  calibrate(place, with(left_alone, kBrown));
  const fs::path again = fresh_folder() / "again";
  fs::create_directories(again);
  write_text(again / "start.json", calibration().dump());
  const std::vector<std::string> start{"--model", "brown_conrady", "--start", (again / "start.json").string()};
  calibrate(again, with(all, start));
  EXPECT_NEAR(baseline_m(json_of(again / "out" / "calibration.json"), "left", "right"), 0.0832, 0.0005);
  std::vector<std::string> kept = with(with(all, start), {"--fix", "right.intrinsics", "-o", (again / "out").string()});
  kept.insert(kept.begin(), "calibrate");
  const ProgramRun refused = raybundle_program(kept);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find("'right.fx' is to be kept, but the file of --start does not say"), std::string::npos)
      << refused.err;
}

// A prior so sharp that the corners have no say is one that they may contradict most.
TEST_F(Subsets, PriorsThatOverruleTheCornersAreWarnedOf) {
  const auto warnings_of = [&](const char* prior) {
    return calibrate(place, with(all, {"--model", "brown_conrady", "--prior", prior}))["warnings"].dump();
  };
  EXPECT_NE(
      warnings_of("right.camera_from_rig.translation_x=-0.1:0.00001").find("translation_x is kept at -0.1, where"),
      std::string::npos);
  EXPECT_EQ(warnings_of("right.camera_from_rig.translation_x=-0.0832:0.00001").find("is kept at"), std::string::npos);
}

// Boards keep their shape, and values that the corners contradict are named as those that were typed.
TEST_F(Subsets, WhatIsKeptWithoutAValueHasThatOfTheStart) {
  calibrate(place, with(all, kBrown));
  const nlohmann::json before = calibration();
  const fs::path again = fresh_folder() / "again";
  fs::create_directories(again);
  const auto from_start = [&](const char* pattern) {
    write_text(again / "start.json", text_of(place / "out" / "calibration.json"));
    return calibrate(again, with(all, {"--model", "brown_conrady", "--start", (again / "start.json").string(), "--fix",
                                       pattern}))["warnings"]
        .dump();
  };
  EXPECT_EQ(from_start("board.shape").find("is kept at"), std::string::npos);
  const nlohmann::json after = json_of(again / "out" / "calibration.json");
  EXPECT_EQ(after["targets"][0]["shape"], before["targets"][0]["shape"]);
  ASSERT_NE(before["targets"][0]["shape"]["bend_y_m"], 0.0);
  calibrate(place, with(all, {"--model", "brown_conrady", "--fix", "left.cx=310"}));
  EXPECT_NE(from_start("left.intrinsics").find("left.cx is kept at 310"), std::string::npos);
}

TEST_F(Subsets, RulesThatSayNothingAreNamed) {
  std::vector<std::string> both = with(all, {"--model", "brown_conrady", "--fix", "left.cx=320", "--prior",
                                             "left.cx=330:5", "-o", (place / "out").string()});
  both.insert(both.begin(), "calibrate");
  EXPECT_NE(raybundle_program(both).err.find("'left.cx' is without effect"), std::string::npos);
  std::vector<std::string> group =
      with(all, {"--model", "brown_conrady", "--fix", "*.intrinsics=500", "-o", (place / "out").string()});
  group.insert(group.begin(), "calibrate");
  const ProgramRun refused = raybundle_program(group);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find("which cannot have one value"), std::string::npos) << refused.err;
}

TEST_F(Subsets, FixedParametersStayAndPriorsPull) {
  calibrate(place, with(all, {"--model", "brown_conrady", "--fix", "*.k3=0", "--fix", "left.cx=340", "--prior",
                              "right.fx=540:0.01"}));
  const nlohmann::json found = calibration();
  EXPECT_EQ(camera_in(found, "left").at("parameters").at("k3"), 0.0);
  EXPECT_EQ(camera_in(found, "right").at("parameters").at("k3"), 0.0);
  EXPECT_EQ(camera_in(found, "left").at("parameters").at("cx"), 340.0);
  // Free it is about 537.5; the prior is some thirty times as sharp as the images.
  EXPECT_NEAR(camera_in(found, "right").at("parameters").at("fx"), 540.0, 0.1);
}

TEST_F(Subsets, OneAndTwoThreadsGiveTheSameBits) {
  calibrate(place, with(all, {"--model", "brown_conrady", "--threads", "1"}));
  const std::string one = without_provenance(place / "out" / "calibration.json");
  calibrate(place, with(all, {"--model", "brown_conrady", "--threads", "2", "--no-cache"}));
  EXPECT_EQ(one, without_provenance(place / "out" / "calibration.json"));
}

TEST_F(Subsets, CamerasThatSeeDifferentFramesAreLinkedByThoseTheyShare) {
  const auto report = calibrate(place, with(stereo_images("left0*.jpg", "right[01][3-9].jpg"), kBrown));
  ASSERT_TRUE(report.contains("cameras"));
  EXPECT_EQ(camera_in(report, "left").at("views_used"), 9);
  EXPECT_EQ(camera_in(report, "right").at("views_used"), 9);
  calibrate(fresh_folder(), with(all, kBrown));
  // Seven shared frames of thirteen: the baseline is as good as one per cent.
  EXPECT_NEAR(baseline_m(calibration(), "left", "right"), 0.0832, 0.0008);
}

TEST_F(Subsets, DetectedCornersGiveTheSameCalibrationAsTheirImages) {
  calibrate(place, with(all, {"--model", "brown_conrady", "--no-predicted-corners"}));
  const std::string from_images = without_provenance(place / "out" / "calibration.json");
  detect(place, all);
  calibrate(place, {"--observations", (place / "observations.json").string(), "--model", "brown_conrady"});
  EXPECT_EQ(from_images, without_provenance(place / "out" / "calibration.json"));
}

TEST_F(Subsets, TheDatasetFileSaysTheSameAsTheFlags) {
  calibrate(place, with(all, kBrown));
  const std::string from_flags = without_provenance(place / "out" / "calibration.json");
  std::string toml = "[target]\nkind = \"chessboard\"\ncolumns = 9\nrows = 6\nsquare_m = 0.025\n";
  for (const char* name : {"left", "right"}) {
    toml += fmt::format("[[camera]]\nname = \"{0}\"\nimages = \"{1}/{0}*.jpg\"\nmodel = \"brown_conrady\"\n", name,
                        fs::absolute(real_data(kStereo)).string());
  }
  write_text(place / "dataset.toml", toml);
  calibrate(place, {(place / "dataset.toml").string()});
  EXPECT_EQ(from_flags, without_provenance(place / "out" / "calibration.json"));
}

TEST_F(Subsets, ValidationPassesOnTheOtherHalfAndFailsAnImpossibleGate) {
  calibrate(place, with(stereo_images("left*[13579].jpg", "right*[13579].jpg"), kBrown));
  const std::string file = (place / "out" / "calibration.json").string();
  const auto held_out = stereo_images("left*[02468].jpg", "right*[02468].jpg");
  const ProgramRun passed = raybundle_program(with({"validate", file, "--json"}, held_out));
  EXPECT_EQ(passed.exit_code, 0) << passed.err << passed.out;
  const nlohmann::json verdict = nlohmann::json::parse(passed.out);
  EXPECT_EQ(verdict.at("passed"), true);
  for (const char* name : {"left", "right"}) {
    EXPECT_EQ(camera_in(verdict, name).at("views_used"), 6) << name;
    EXPECT_LE(camera_in(verdict, name).at("rms_px"), 0.3) << name;
    EXPECT_GT(camera_in(verdict, name).at("median_px"), 0.0) << name;
  }
  const ProgramRun failed = raybundle_program(with({"validate", file, "--json", "--max-rms", "0.01"}, held_out));
  EXPECT_EQ(failed.exit_code, 1) << failed.err;
  EXPECT_EQ(nlohmann::json::parse(failed.out).at("passed"), false);
}

// Each image fits its own camera, whatever its number: only both cameras together tell that pairs are mixed up.
TEST_F(Subsets, ValidationFailsForPairsOfDifferentMoments) {
  calibrate(place, with(all, kBrown));
  const fs::path mixed = place / "mixed";
  fs::create_directories(mixed);
  const std::map<int, int> other{{1, 2}, {2, 1}, {3, 4}, {4, 3}};
  for (int number = 1; number <= 9; ++number) {
    const int right = other.contains(number) ? other.at(number) : number;
    fs::copy_file(real_data(kStereo) / fmt::format("left0{}.jpg", number), mixed / fmt::format("left{}.jpg", number));
    fs::copy_file(real_data(kStereo) / fmt::format("right0{}.jpg", right), mixed / fmt::format("right{}.jpg", number));
  }
  const auto validate = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"validate", (place / "out" / "calibration.json").string(), "--target",
                               "chessboard:9x6:25mm", "--camera", "left=" + (mixed / "left*.jpg").string()});
    return raybundle_program(more);
  };
  const std::string right = "right=" + (mixed / "right*.jpg").string();
  const ProgramRun run = validate({"--camera", right});
  EXPECT_EQ(run.exit_code, 1) << run.out;
  EXPECT_NE(run.out.find("saw the board in another place"), std::string::npos) << run.out;
  const nlohmann::json verdict = nlohmann::json::parse(validate({"--camera", right, "--json"}).out);
  EXPECT_EQ(verdict.at("passed"), false);
  for (const char* name : {"left", "right"}) EXPECT_GE(camera_in(verdict, name).at("views_apart"), 4) << name;
  EXPECT_EQ(validate({}).exit_code, 0) << "the left camera alone has nothing to disagree with";
}

TEST_F(Subsets, ProjectAndUnprojectUndoEachOther) {
  calibrate(place, with(all, kBrown));
  const std::string file = (place / "out" / "calibration.json").string();
  const ProgramRun rays = raybundle_program({"unproject", file, "--camera", "right"}, "0,0\n320.5,240.25\n639,479\n");
  ASSERT_EQ(rays.exit_code, 0) << rays.err;
  const ProgramRun pixels = raybundle_program({"project", file, "--camera", "right"}, rays.out);
  ASSERT_EQ(pixels.exit_code, 0) << pixels.err;
  double u[3], v[3];
  ASSERT_EQ(std::sscanf(pixels.out.c_str(), "%lf,%lf\n%lf,%lf\n%lf,%lf", u, v, u + 1, v + 1, u + 2, v + 2), 6);
  const double expected_u[] = {0, 320.5, 639}, expected_v[] = {0, 240.25, 479};
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(u[i], expected_u[i], 1e-8);
    EXPECT_NEAR(v[i], expected_v[i], 1e-8);
  }
  EXPECT_EQ(raybundle_program({"project", file, "--camera", "middle"}, "0,0,1\n").exit_code, 2);
  EXPECT_EQ(raybundle_program({"project", file, "--camera", "left"}, "0,zero,1\n").exit_code, 2);
  EXPECT_EQ(raybundle_program({"project", file, "--camera", "left"}, "inf,0,1\n").out, "nan,nan\n");
}

// Three cameras of which the first and the last never see a board at once.
TEST(SyntheticSubsets, CamerasAreLinkedThroughAChainOfSharedFrames) {
  SyntheticOptions options;
  options.cameras.resize(3);
  options.cameras[1].camera_from_rig.translation = {-0.1, 0, 0};
  options.cameras[2].camera_from_rig.translation = {-0.25, 0.02, 0};
  options.frames = 24;
  SyntheticWorld world = synthetic_world(options);
  std::erase_if(world.problem.views, [](const TargetView& view) {
    return (view.camera == 0 && view.frame >= 12) || (view.camera == 2 && view.frame < 12);
  });
  const fs::path place = fresh_folder();
  write_text(place / "corners.csv", csv_of(world.problem));
  calibrate(place, {"--observations", (place / "corners.csv").string(), "--target", "chessboard:9x7:40mm", "--model",
                    "kannala_brandt", "--image-size", "camera0=1280x960", "--image-size", "camera1=1280x960",
                    "--image-size", "camera2=1280x960"});
  const nlohmann::json found = json_of(place / "out" / "calibration.json");
  const Rigid3 truth = world.camera_from_rig[2];
  // Exact corners: what remains is the ten decimals of the table.
  EXPECT_LT((camera_from_rig(found, "camera2").translation - truth.translation).norm(), 1e-6);
}

TEST(Provenance, SaysWhatWasRunOnWhichFilesAndNotWhereTheResultsWent) {
  SyntheticOptions options;
  options.frames = 10;
  options.noise_px = 0.1;
  const fs::path place = fresh_folder();
  write_text(place / "corners.csv", csv_of(synthetic_world(options).problem));
  write_text(place / "board.toml", "[target]\nkind = \"chessboard\"\ncolumns = 9\nrows = 7\nsquare_m = 0.04\n");
  write_text(place / "gates.toml", "require = [\"rms 1 px\"]\n");
  const std::string board = (place / "board.toml").string(), gates = (place / "gates.toml").string();
  const std::string corners = (place / "corners.csv").string(), start = (place / "out/calibration.json").string();
  const std::vector<std::string> first{"--observations", corners, "--image-size", "camera0=1280x960",
                                       "--target",       board,   "--model",      "kannala_brandt"};
  calibrate(place, first);
  const std::vector<std::string> again =
      with(first, {"--start", start, "--fix", "*.k4=0", "--fix", "*.k3=0", "--free", "*.k3", "--prior",
                   "camera0.cx=640:50", "--no-predicted-corners", "--outlier-sigma", "4", "--gates", gates});
  calibrate(place / "a", with(again, {"--threads", "1"}));
  calibrate(place / "b", with(again, {"--threads", "2", "--no-cache"}));
  EXPECT_EQ(text_of(place / "a/out/calibration.json"), text_of(place / "b/out/calibration.json"));

  const nlohmann::json provenance = json_of(place / "a/out/calibration.json").at("provenance");
  std::vector<std::string> said, inputs;
  for (const nlohmann::json& option : provenance.at("options")) {
    said.push_back(option.at("name").get<std::string>() + " " + option.at("value").get<std::string>());
  }
  EXPECT_THAT(said,
              ::testing::IsSupersetOf({"--target " + board, "--start " + start, std::string("--fix *.k4=0"),
                                       std::string("--fix *.k3=0"), std::string("--free *.k3"),
                                       std::string("--prior camera0.cx=640:50"),
                                       std::string("--no-predicted-corners true"), std::string("outlier_sigma 4")}));
  for (const nlohmann::json& input : provenance.at("inputs")) inputs.push_back(input.at("path"));
  EXPECT_THAT(inputs, ::testing::UnorderedElementsAre(corners, start, gates, board));
}

}  // namespace
}  // namespace raybundle::testing
