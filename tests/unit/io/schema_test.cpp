// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fstream>
#include <limits>

#include "io_examples.hpp"
#include "raybundle/io/report_file.hpp"
#include "schema_walker.hpp"

namespace raybundle::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Json = nlohmann::json;

SchemaWalker schema(const std::string& name) {
  std::ifstream stream(RAYBUNDLE_SOURCE_DIR "/docs/schemas/" + name + ".schema.json");
  return SchemaWalker(Json::parse(stream));
}

// A result with one of everything: an outlier, a residual that does not exist, a view and an image set aside.
CalibrationResult result_for(const CalibrationProblem& problem) {
  CalibrationResult result;
  result.calibration = full_calibration().calibration;
  result.calibration.cameras.resize(problem.cameras.size() - 1);  // the last camera could not be calibrated
  result.calibration.cameras[0].name = problem.cameras[0].name;
  result.calibration.covariance.names[0] = problem.cameras[0].name + ".fx";
  result.calibration.covariance.names[2] = problem.targets[0].name + ".bend_x";
  result.poses = {{0, 0, awkward_rigid3(2)}};
  for (const TargetView& view : problem.views) {
    ViewResult of_view;
    of_view.pose = 0;
    of_view.rms_px = 0.25;
    of_view.residuals_px.assign(view.observations.size(), {0.1, -0.2});
    of_view.fates.assign(view.observations.size(), ObservationFate::kUsed);
    result.views.push_back(of_view);
  }
  result.views[0].fates[0] = ObservationFate::kOutlier;
  result.views[0].fates[1] = ObservationFate::kUnprojectable;
  result.views[0].residuals_px[1].setConstant(std::numeric_limits<double>::quiet_NaN());
  result.views[1] = {};
  result.set_aside = {{1, SetAside::Scope::kView, "its best pose leaves 7.1 px"},
                      {2, SetAside::Scope::kExtrinsics, "the cameras disagree by 3 mm"}};
  result.cameras.assign(problem.cameras.size(), {0.25, 0.2, 3, 4, 44, 1});
  result.rms_px = 0.25;
  result.termination = Termination::kConverged;
  result.gauge = "the first camera";
  result.warnings = {"camera right saw no board near its rim"};
  result.stages = {{"detect", 1.5}, {"solve", 0.25}};
  return result;
}

Json example_report() {
  const CalibrationProblem problem = small_observations().problem;
  const ReportExtra extra{{{"left", "9", "left09.jpg", "no board found"}}, full_calibration().provenance};
  return Json::parse(text_from_report(problem, result_for(problem), extra));
}

TEST(Schema, WrittenFilesConform) {
  EXPECT_THAT(schema("calibration").complaints(Json::parse(text_from_calibration(full_calibration()))), IsEmpty());
  EXPECT_THAT(schema("observations").complaints(Json::parse(text_from_observations(small_observations()))), IsEmpty());
  EXPECT_THAT(schema("report").complaints(example_report()), IsEmpty());
}

// A key that a schema does not name is one that nobody can rely on.
TEST(Schema, KnowsEveryKeyThatIsWritten) {
  CalibrationFile calibration = full_calibration();
  LaserPattern& pattern = *calibration.calibration.laser;
  pattern.advice = LabelAdvice{};
  pattern.advice->best_turn = TurnedPattern{0.1, 0.5};
  pattern.advice->ambiguity.pairs = {{0, 2, 1.5}};
  const Json written = Json::parse(text_from_calibration(calibration));
  EXPECT_THAT(schema("calibration").unknown(written), IsEmpty());
  EXPECT_THAT(schema("calibration").complaints(written), IsEmpty());
  EXPECT_THAT(schema("observations").unknown(Json::parse(text_from_observations(small_observations()))), IsEmpty());

  const CalibrationProblem problem = small_observations().problem;
  CalibrationResult result = result_for(problem);
  result.calibration.laser = pattern;
  result.laser = LaserSummary{};
  result.laser->parameters = {{"camera0.fx", 400.0, 401.0, 0.5}};
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    result.views[v].beam_of_dot.assign(problem.views[v].dots.size(), 0);
    result.views[v].dot_fates.assign(problem.views[v].dots.size(), ObservationFate::kUsed);
    result.views[v].dot_residuals_px.assign(problem.views[v].dots.size(), {0.1, 0.2});
  }
  const Json report = Json::parse(text_from_report(problem, result));
  ASSERT_TRUE(report["views"][0].contains("dots") && report.contains("sigma_ratio_by_frame"));
  EXPECT_THAT(schema("report").unknown(report), IsEmpty());
  EXPECT_THAT(schema("report").complaints(report), IsEmpty());
}

TEST(Schema, FindsWhatIsWrong) {
  Json json = Json::parse(text_from_calibration(full_calibration()));
  json["cameras"][0].erase("width");
  json["cameras"][1]["parameters"]["k9"] = "a text";
  json["version"] = 2;
  EXPECT_EQ(schema("calibration").complaints(json).size(), 3u);
}

TEST(Report, HoldsTheNamesThatOthersScriptAgainst) {
  const Json report = example_report();
  EXPECT_EQ(report["rms_px"], 0.25);
  EXPECT_EQ(report["cameras"][0]["name"], "camera0");
  for (const char* key : {"rms_px", "median_px", "views_used", "views_total", "corners_used"}) {
    EXPECT_TRUE(report["cameras"][0][key].is_number()) << key;
  }
  EXPECT_EQ(report["stages"][0]["name"], "detect");
  EXPECT_EQ(report["stages"][0]["seconds"], 1.5);
  ASSERT_EQ(report["set_aside"].size(), 3u);
  EXPECT_EQ(report["set_aside"][0]["camera"], "camera1");
  EXPECT_EQ(report["set_aside"][0]["frame"], "0");
  EXPECT_EQ(report["set_aside"][1]["scope"], "extrinsics");
  EXPECT_EQ(report["set_aside"][2]["reason"], "no board found");
}

TEST(Report, HoldsTheEstimatesWithTheirSigmas) {
  const Json report = example_report();
  const Json camera = report["cameras"][0];
  EXPECT_TRUE(camera["parameters"]["fx"].is_number());
  EXPECT_EQ(camera["sigmas"], Json({{"fx", std::sqrt(1.0 / 3.0)}}));
  EXPECT_EQ(camera["camera_from_rig"]["translation_m"].size(), 3u);
  EXPECT_FALSE(report["cameras"][1].contains("parameters"));
  EXPECT_EQ(report["targets"][0]["shape_sigmas"], Json({{"bend_x_m", std::sqrt(0.7)}}));
}

TEST(Report, KeepsEveryObservationWithResidualAndFate) {
  const CalibrationProblem problem = small_observations().problem;
  const Json report = example_report();
  ASSERT_EQ(report["views"].size(), problem.views.size());
  for (std::size_t i = 0; i < problem.views.size(); ++i) {
    ASSERT_EQ(report["views"][i]["observations"].size(), problem.views[i].observations.size());
  }
  const Json rows = report["views"][0]["observations"];
  EXPECT_EQ(rows[0][1], problem.views[0].observations[0].pixel.x());
  EXPECT_EQ(report["fates"][rows[0][6].get<int>()], "outlier");
  EXPECT_TRUE(rows[1][4].is_null());
  EXPECT_EQ(report["fates"][rows[1][6].get<int>()], "unprojectable");
  EXPECT_EQ(report["fates"][rows[2][6].get<int>()], "used");
  EXPECT_EQ(rows[2][5], -0.2);
  EXPECT_EQ(report["fates"][report["views"][1]["observations"][0][6].get<int>()], "view_set_aside");
  EXPECT_EQ(report["views"][1]["pose"], -1);
}

TEST(Report, HasALineForEachView) {
  CalibrationProblem problem = small_observations().problem;
  const std::string text = text_from_report(problem, result_for(problem));
  const std::size_t begin = text.find("\"views\": [\n"), end = text.find("\n  ]", begin);
  ASSERT_LT(begin, end);
  EXPECT_EQ(std::count(text.begin() + static_cast<std::ptrdiff_t>(begin),
                       text.begin() + static_cast<std::ptrdiff_t>(end), '\n'),
            std::ssize(problem.views));
  problem.views.clear();
  EXPECT_THAT(text_from_report(problem, CalibrationResult{}), HasSubstr("\"views\": []"));
}

TEST(Report, ASectionKeepsViewsOfItsOwn) {
  const CalibrationProblem problem = small_observations().problem;
  ReportExtra extra;
  extra.sections.push_back({"next_views", R"({"views": [{"text": "tilt it"}]})"});
  const Json report = Json::parse(text_from_report(problem, result_for(problem), extra));
  EXPECT_EQ(report["next_views"]["views"][0]["text"], "tilt it");
  EXPECT_EQ(report["views"].size(), problem.views.size());
}

TEST(Report, AFileNameThatIsNotUtf8DoesNotFailIt) {
  CalibrationProblem problem = small_observations().problem;
  problem.views[0].image = "\xff.jpg";
  EXPECT_THAT(text_from_report(problem, result_for(problem)), HasSubstr("\xEF\xBF\xBD.jpg"));
}

}  // namespace
}  // namespace raybundle::testing
