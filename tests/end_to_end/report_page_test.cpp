// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "report_page.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>

#include "browser.hpp"
#include "calibration_summary.hpp"
#include "judgement.hpp"
#include "laser_world.hpp"
#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/io/report_file.hpp"
#include "raybundle/scene/atomic_file.hpp"
#include "synthetic_world.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

// Two cameras, a hostile file name and an image without a board.
struct Example {
  CalibrationProblem problem;
  CalibrationResult result;
  ReportExtra extra{{{"camera0", "99", "99.jpg", "no board found"}}, {}};
};

Example example() {
  SyntheticOptions options = stereo_head();
  options.frames = 10;
  options.noise_px = 0.2;
  Example made;
  made.problem = synthetic_world(options).problem;
  made.problem.views[0].image = "</script><h1>left over</h1>.jpg";
  made.result = calibrate(made.problem);
  const apps::Judgements judged = apps::judge(made.problem, made.result, {requirement_from_text("rms 0.01 px")}, 2);
  made.extra.sections = apps::sections_of(judged, made.result);
  return made;
}

TEST(ReportPage, LetsNoForeignTextOutOfItsPlace) {
  const Example made = example();
  const std::string page = apps::report_page(text_from_report(made.problem, made.result, made.extra), "a \"folder\"");
  EXPECT_THAT(page, Not(HasSubstr("{{")));
  EXPECT_THAT(page, Not(HasSubstr("</script><h1>")));
  EXPECT_THAT(page, HasSubstr("data-images=\"a &quot;folder&quot;/\""));
}

class ReportPageInBrowser : public ::testing::Test {
 protected:
  void SetUp() override {
    if (browser_name().empty()) GTEST_SKIP() << "there is no chromium: install it to open the report in a real browser";
    fs::remove_all(folder);
    fs::create_directories(folder);
    browser.emplace(folder / "profile");
    browser->set_window(1280, 900);
  }

  // Writes the page of a report and opens it.
  void open(const std::string& report) {
    write_file_whole(folder / "report.html", apps::report_page(report));
    browser->open(folder / "report.html");
    ASSERT_EQ(browser->evaluate("document.documentElement.dataset.drawn"), "yes")
        << browser->evaluate("document.body.innerText.slice(0, 400)");
  }

  std::string text(const std::string& selector) {
    return browser->evaluate(fmt::format("document.querySelector({}).textContent", nlohmann::json(selector).dump()));
  }

  // One for each test, for they run side by side; the pictures stay there.
  const fs::path folder = fs::path(RAYBUNDLE_BINARY_DIR) / "report_page_test" /
                          ::testing::UnitTest::GetInstance()->current_test_info()->name();
  std::optional<Browser> browser;
};

TEST_F(ReportPageInBrowser, ShowsEverySectionAndAsksForNothing) {
  const Example made = example();
  open(text_from_report(made.problem, made.result, made.extra));
  EXPECT_THAT(text(".tiles dd"), HasSubstr(fmt::format("{:.3f}", made.result.rms_px)));
  const std::string page = text("main");
  for (const char* heading :
       {"Verdict", "rms 0.01 px", "Next best views", "Camera camera0", "How well projections are known",
        "Camera camera1", "The rig", "Images without a view (1)"}) {
    EXPECT_THAT(page, HasSubstr(heading));
  }
  EXPECT_THAT(text(".headline"), HasSubstr("Not good enough"));
  EXPECT_THAT(browser->errors, IsEmpty());
  for (const std::string& request : browser->requests)
    EXPECT_THAT(request, AnyOf(HasSubstr("file:"), HasSubstr("data:")));
}

TEST_F(ReportPageInBrowser, ShowsTheLaserAndCountsWarnings) {
  SyntheticWorld world = synthetic_world(laser_rig_options(30, 4));
  add_laser(world, {.brightest_factor = 2.0, .seed = 4});
  world.problem.laser->brightest = 60;
  const CalibrationResult result = calibrate(world.problem);
  ASSERT_TRUE(result.laser);
  ReportExtra extra;
  extra.sections = apps::sections_of(apps::judge(world.problem, result, {}, 2), result);
  open(text_from_report(world.problem, result, extra));
  EXPECT_THAT(text("#laser"), AllOf(HasSubstr("of 121 beams"), HasSubstr("tells depth"), HasSubstr("camera0.fx")));
  CalibrationResult warned = result;
  warned.warnings.clear();
  open(text_from_report(world.problem, warned, {}));
  EXPECT_EQ(browser->evaluate("document.querySelector('.headline')"), nullptr);  // nothing was judged
  extra.sections = {{"verdict", R"({"grade": null, "judgements": [], "findings": []})"}};
  open(text_from_report(world.problem, warned, extra));
  EXPECT_THAT(text(".headline"), HasSubstr("Nothing speaks against it"));
  warned.warnings.emplace_back("something is odd");
  open(text_from_report(world.problem, warned, extra));
  EXPECT_THAT(text(".headline"), HasSubstr("1 thing to look at"));
  EXPECT_THAT(browser->errors, IsEmpty());
}

// Does not look at what is drawn, only that it changes when it is turned.
TEST_F(ReportPageInBrowser, TurnsTheRigByKeyAndHidesBoards) {
  const Example made = example();
  open(text_from_report(made.problem, made.result, made.extra));
  const auto picture = [&] { return browser->evaluate("document.querySelector('.rig canvas').toDataURL()"); };
  browser->click(".rig canvas");
  const auto first = picture();
  browser->press("ArrowLeft");
  const auto turned = picture();
  EXPECT_NE(turned, first);
  browser->click(".rig input");
  EXPECT_NE(picture(), turned);
  EXPECT_THAT(browser->errors, IsEmpty());
}

TEST_F(ReportPageInBrowser, ShowsTheViewThatIsChosen) {
  const Example made = example();
  open(text_from_report(made.problem, made.result, made.extra));
  const std::string before = text(".views figcaption strong");
  browser->click(".views tbody tr:nth-child(3) button");
  EXPECT_NE(text(".views figcaption strong"), before);
}

// Where the frames scatter by more than the corners' noise, page and terminal show what the frames say, and say so.
TEST_F(ReportPageInBrowser, ShowsTheSigmasOfTheTerminal) {
  Example made = example();
  Calibration& calibration = made.result.calibration;
  calibration.covariance_by_frame = {calibration.covariance.names, 9.0 * calibration.covariance.matrix};
  made.extra.sections = apps::sections_of(apps::judge(made.problem, made.result, {}, 2), made.result);
  open(text_from_report(made.problem, made.result, made.extra));
  const auto by_page = [&](const std::string& selector) {
    std::string words = text(selector);
    const std::string sign = "± ";
    return std::stod(words.substr(words.find(sign) + sign.size()));
  };
  const RigCamera& camera = calibration.cameras[1];
  constexpr double kTwoDigits = 0.05;  // of the value: what rounding to two digits may take
  const double baseline_mm = 1e3 * baseline_sigma(camera, calibration);
  EXPECT_NEAR(by_page("#rig table td:nth-child(2)"), baseline_mm, kTwoDigits * baseline_mm);
  const double fx_px = 3.0 * calibration.covariance.sigma("camera1.fx");
  EXPECT_NEAR(by_page("[aria-label='Parameters of camera1'] tbody td:nth-child(3)"), fx_px, kTwoDigits * fx_px);
  EXPECT_THAT(text("main"), HasSubstr("how the frames scatter, whichever is larger"));
  EXPECT_THAT(apps::summary_text(made.problem, made.result, {}),
              AllOf(HasSubstr(fmt::format("± {:.2f} mm", baseline_mm)), HasSubstr("whichever is larger")));
}

// The solve takes pixels as they are stored, so that a page may not turn a photo as its EXIF says.
TEST_F(ReportPageInBrowser, DoesNotTurnPhotos) {
  const Example made = example();
  open(text_from_report(made.problem, made.result, made.extra));
  EXPECT_EQ(browser->evaluate("getComputedStyle(document.querySelector('.photo img')).imageOrientation"), "none");
}

// The beams of a laser stand in space beside the boards, and say how many they are.
TEST_F(ReportPageInBrowser, ShowsLaserBeams) {
  Example made = example();
  LaserPattern pattern;
  pattern.grid = {1, 2};
  for (int column = 0; column < 2; ++column) {
    LaserBeam beam;
    beam.column = column;
    beam.line = {{0.1, 0.0, 0.5}, Eigen::Vector3d(0.1 * column, 0.0, 1.0).normalized()};
    beam.hits = 7;
    beam.nearest_hit_m = 0.3;
    beam.farthest_hit_m = 0.9;
    pattern.beams.push_back(beam);
  }
  made.result.calibration.laser = pattern;
  made.result.laser = LaserSummary{};
  open(text_from_report(made.problem, made.result, made.extra));
  EXPECT_THAT(text(".rig .controls"), HasSubstr("2 laser beams"));
  EXPECT_THAT(browser->errors, IsEmpty());
}

// 500 views of 140 corners make a page below 10 MB, which is drawn; `./dev bench report` tells how fast.
TEST_F(ReportPageInBrowser, OpensLargeReports) {
  SyntheticOptions options;
  options.frames = 500;
  options.columns = 14;
  options.rows = 10;
  options.square_m = 0.025;
  options.noise_px = 0.2;
  const CalibrationProblem problem = synthetic_world(options).problem;
  const CalibrationResult result = calibrate(problem);
  open(text_from_report(problem, result));
  EXPECT_LT(fs::file_size(folder / "report.html"), 10e6);
}

// Looks at the page as people with other screens see it; the pictures stay beside the page for a person to look at.
TEST_F(ReportPageInBrowser, FitsDarkAndNarrowScreens) {
  const Example made = example();
  open(text_from_report(made.problem, made.result, made.extra));
  browser->take_picture(folder / "report.png");
  const auto background = [&] { return browser->evaluate("getComputedStyle(document.body).backgroundColor"); };
  const auto light = background();
  browser->set_dark(true);
  EXPECT_NE(background(), light);
  browser->set_window(390, 844);
  browser->take_picture(folder / "report_narrow_dark.png");
  EXPECT_LE(browser->evaluate("document.documentElement.scrollWidth").get<int>(), 390);
  EXPECT_GT(cv::imread((folder / "report.png").string()).cols, 0);
}

}  // namespace
}  // namespace raybundle::testing
