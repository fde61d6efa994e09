// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cmath>

#include "program.hpp"
#include "schema_walker.hpp"
#include "survey_text.hpp"
#include "synthetic_world.hpp"
#include "tables.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::IsEmpty;

// What calibrate() leaves is held against the schema beside its writer; here is what the program adds. Comparisons have
// no schema of their own, and without images there are no pictures.
TEST(ReportSchema, KnowsEverySectionThatTheProgramWrites) {
  SyntheticOptions options;
  options.cameras.resize(2);
  options.cameras[1].camera_from_rig.translation = {-0.1, 0, 0};
  options.frames = 12;
  options.noise_px = 0.1;
  const fs::path place = fresh_folder();
  write_text(place / "corners.csv", csv_of(synthetic_world(options).problem));
  nlohmann::json report = calibrate(
      place, {"--observations", (place / "corners.csv").string(), "--image-size", "camera0=1280x960", "--image-size",
              "camera1=1280x960", "--target", "chessboard:9x7:40mm", "--model", "kannala_brandt", "--require",
              "rms 1 px", "--cross-validate", "--second-opinion", "--fix", "*.k4=0"});
  for (const char* section :
       {"verdict", "baselines", "next_views", "uncertainty_maps", "cross_validation", "second_opinion"}) {
    EXPECT_FALSE(report[section].empty()) << section;
  }
  SurveySummary survey;
  survey.parameters = {{"camera0.fx", 400.0, 401.0, 0.5}};
  SurveyImage& image = survey.images.emplace_back();
  image.image = "towers.jpg";
  image.camera = "camera0";
  image.pose_sigma.setConstant(std::nan(""));
  image.landmarks = {{"tower", {1, 2}, {0.5, 0}, INFINITY, 0.5, 0.5, 1.0, true}};
  report["survey"] = apps::json_from_survey(survey);
  const SchemaWalker schema(json_of(RAYBUNDLE_SOURCE_DIR "/docs/schemas/report.schema.json"));
  EXPECT_THAT(schema.complaints(report), IsEmpty());
  EXPECT_THAT(schema.unknown(report), IsEmpty());
}

}  // namespace
}  // namespace raybundle::testing
