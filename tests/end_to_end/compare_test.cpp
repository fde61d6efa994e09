// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "program.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

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
