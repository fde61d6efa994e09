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
#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/io/report_file.hpp"
#include "raybundle/scene/atomic_file.hpp"
#include "synthetic_world.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;
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
  SyntheticOptions options;
  options.cameras.resize(2);
  options.cameras[1].camera_from_rig.translation = {-0.1, 0, 0};
  options.frames = 10;
  options.noise_px = 0.2;
  Example made;
  made.problem = synthetic_world(options).problem;
  made.problem.views[0].image = "</script><h1>left over</h1>.jpg";
  made.result = calibrate(made.problem);
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

  const fs::path folder = RAYBUNDLE_BINARY_DIR "/report_page_test";
  std::optional<Browser> browser;
};

TEST_F(ReportPageInBrowser, ShowsEverySectionAndAsksForNothing) {
  const Example made = example();
  open(text_from_report(made.problem, made.result, made.extra));
  EXPECT_THAT(text(".tiles dd"), HasSubstr(fmt::format("{:.3f}", made.result.rms_px)));
  const std::string page = text("main");
  for (const char* heading : {"Camera camera0", "Camera camera1", "The rig", "Images without a view (1)"}) {
    EXPECT_THAT(page, HasSubstr(heading));
  }
  EXPECT_THAT(browser->errors, IsEmpty());
  for (const std::string& request : browser->requests)
    EXPECT_THAT(request, AnyOf(HasSubstr("file:"), HasSubstr("data:")));
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
