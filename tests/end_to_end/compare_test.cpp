// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "program.hpp"
#include "raybundle/io/calibration_file.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

// An equidistant fisheye that saw corners all over its image, and whose intrinsics are known to 0.2 px.
CalibrationFile one_fisheye() {
  CalibrationFile file;
  RigCamera one{"one", start_camera(*model_named("kannala_brandt"), {640, 480}, 250.0), {}};
  one.evidence = CornerEvidence{16, 12, std::vector<int>(16 * 12, 5), Eigen::MatrixXd::Zero(6, 8)};
  file.calibration.cameras = {one};
  file.calibration.covariance = {{"one.fx", "one.fy", "one.cx", "one.cy"}, 0.04 * Eigen::Matrix4d::Identity()};
  return file;
}

// Runs compare on one_fisheye() and one of other parameters.
ProgramRun compared_with(const Eigen::VectorXd& parameters, std::vector<std::string> flags) {
  const fs::path place = fresh_folder();
  CalibrationFile other = one_fisheye();
  other.calibration.cameras[0].camera.parameters = parameters;
  write_calibration(place / "a.json", one_fisheye());
  write_calibration(place / "b.json", other);
  flags.insert(flags.begin(), {"compare", (place / "a.json").string(), (place / "b.json").string()});
  return raybundle_program(flags);
}

const char* kFolder = "opencv_stereo_chess";

std::vector<std::string> stereo(const char* model) {
  return {"--target",         "chessboard:9x6:25mm",
          "--camera",         "left=" + (real_data(kFolder) / "left*.jpg").string(),
          "--camera",         "right=" + (real_data(kFolder) / "right*.jpg").string(),
          "--model",          model,
          "--cross-validate", "--second-opinion"};
}

TEST(Compares, ARealRigWithItselfWithAnotherModelAndWithMrcal) {
  RAYBUNDLE_NEEDS_DATA(kFolder);
  const fs::path place = fresh_folder();
  const nlohmann::json report = calibrate(place, stereo("brown_conrady"));
  ASSERT_TRUE(report.contains("cross_validation"));
  EXPECT_THAT(report["cross_validation"]["words"].get<std::string>(), HasSubstr("odd and even frames"));
  // mrcal's own optimiser lands where ours does: the bar is 0.02 px.
  const nlohmann::json& second = report.at("second_opinion").at(0);
  if (second.contains("comparison")) {
    for (const nlohmann::json& projection : second["comparison"]["projections"]) {
      EXPECT_LT(projection["largest_px"].get<double>(), 0.02) << projection["camera"];
    }
  } else {
    EXPECT_THAT(second["why_not"].get<std::string>(), HasSubstr("no mrcal"));
  }
  const std::string first = (place / "out" / "calibration.json").string();
  const ProgramRun same = raybundle_program({"compare", first, first, "--json", "--max-px", "0.001"});
  EXPECT_EQ(same.exit_code, 0) << same.err;
  EXPECT_EQ(nlohmann::json::parse(same.out)["projections"].size(), 2u);
  const ProgramRun near = raybundle_program({"compare", first, first, "--range", "0.5", "--range", "inf"});
  EXPECT_THAT(near.out, HasSubstr("at 0.5 m"));
  EXPECT_THAT(near.out, HasSubstr("agrees"));
}

// The board was moved between the exposures of most pairs: what errs are the few that tie the cameras, not the lenses.
TEST(Compares, HalvesOfAnUnsynchronisedRigWithoutBlamingTheLens) {
  const char* folder = "sourishg_fisheye_stereo/imgs";
  RAYBUNDLE_NEEDS_DATA(folder);
  const nlohmann::json report =
      calibrate(fresh_folder(),
                {"--target", "chessboard:9x6:24.23mm", "--camera", "left=" + (real_data(folder) / "left*.jpg").string(),
                 "--camera", "right=" + (real_data(folder) / "right*.jpg").string(), "--model", "kannala_brandt",
                 "--cross-validate"});
  const nlohmann::json& found = report.at("cross_validation");
  EXPECT_NE(found.at("verdict"), "model_error") << found.at("words");
}

TEST(Compares, GatesMissALensThatHasChanged) {
  Eigen::VectorXd parameters = one_fisheye().calibration.cameras[0].camera.parameters;
  EXPECT_EQ(compared_with(parameters, {"--max-px", "1e-6", "--max-sigmas", "2"}).exit_code, 0);
  parameters[0] *= 1.01;  // 3.2 px at the left and the right of the image, where both sigmas of fx make 0.5 px
  const ProgramRun run = compared_with(parameters, {"--max-px", "2", "--json"});
  EXPECT_EQ(run.exit_code, 1) << run.err;
  const nlohmann::json json = nlohmann::json::parse(run.out);
  EXPECT_EQ(json.at("passed"), false);
  EXPECT_THAT(json.at("missed").at(0).get<std::string>(), HasSubstr("(--max-px)"));
  EXPECT_EQ(compared_with(parameters, {"--max-px", "4"}).exit_code, 0);
  const ProgramRun by_sigmas = compared_with(parameters, {"--max-sigmas", "2"});
  EXPECT_EQ(by_sigmas.exit_code, 1) << by_sigmas.err;
  EXPECT_THAT(by_sigmas.out, HasSubstr("(--max-sigmas)"));
  EXPECT_EQ(compared_with(parameters, {"--max-sigmas", "20"}).exit_code, 0);
}

// It folds 136 px from the middle of the image; what it sees within lies 20 px off at most.
TEST(Compares, GatesMissALensThatEndsAmidTheCorners) {
  Eigen::VectorXd parameters = one_fisheye().calibration.cameras[0].camera.parameters;
  parameters[4] = -0.5;
  EXPECT_THAT(compared_with(parameters, {}).out, HasSubstr("note: one at infinity: one of the lenses sees nothing in"));
  for (const char* gate : {"--max-px", "--max-sigmas"}) {
    const ProgramRun run = compared_with(parameters, {gate, "1000", "--json"});
    EXPECT_EQ(run.exit_code, 1) << gate << run.err;
    const nlohmann::json json = nlohmann::json::parse(run.out);
    EXPECT_EQ(json.at("passed"), false) << gate;
    EXPECT_GT(json.at("projections").at(0).at("lost_share"), 0.5) << gate;
  }
}

TEST(Compares, RefusesWhatIsNoCalibration) {
  const fs::path place = fresh_folder();
  write_text(place / "a.json", "{\"format\": \"raybundle calib");
  const ProgramRun truncated = raybundle_program({"compare", (place / "a.json").string(), (place / "a.json").string()});
  EXPECT_EQ(truncated.exit_code, 2);
  EXPECT_THAT(truncated.err, HasSubstr("a.json"));
  const ProgramRun missing = raybundle_program({"compare", (place / "b.json").string(), (place / "b.json").string()});
  EXPECT_EQ(missing.exit_code, 5);
}

}  // namespace
}  // namespace raybundle::testing
