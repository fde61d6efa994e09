// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "report_page.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/io/report_file.hpp"
#include "raybundle/scene/atomic_file.hpp"
#include "synthetic_world.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

// Chromium's name on this machine; empty when there is none.
std::string browser() {
  for (const char* name : {"chromium", "chromium-browser", "google-chrome"}) {
    if (std::system(fmt::format("command -v {} >/dev/null", name).c_str()) == 0) return name;
  }
  return {};
}

std::string text_of(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

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

TEST(ReportPage, IsOneFileThatAsksForNothing) {
  const Example made = example();
  const std::string page = apps::report_page(text_from_report(made.problem, made.result, made.extra), "a \"folder\"");
  EXPECT_THAT(page, Not(HasSubstr("http://")));
  EXPECT_THAT(page, Not(HasSubstr("https://")));
  EXPECT_THAT(page, Not(HasSubstr("{{")));
  EXPECT_THAT(page, Not(HasSubstr("</script><h1>")));
  EXPECT_THAT(page, HasSubstr("data-images=\"a &quot;folder&quot;/\""));
}

class ReportPageInBrowser : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(folder);
    fs::create_directories(folder);
  }

  // Runs the browser on the page; what it prints goes to dom.html.
  int open_page(const std::string& flags) const {
    return std::system(
        fmt::format("cd '{0}' && timeout 120 {1} --headless --no-sandbox --disable-gpu --hide-scrollbars "
                    "--user-data-dir='{0}/profile' --virtual-time-budget=5000 {2} 'file://{0}/report.html' "
                    ">dom.html 2>browser.log",
                    folder.string(), browser(), flags)
            .c_str());
  }

  const fs::path folder = RAYBUNDLE_BINARY_DIR "/report_page_test";
};

// Does not look at what is drawn, only that all sections stand and that the drawings leave ink on the page.
TEST_F(ReportPageInBrowser, ShowsEverySection) {
  if (browser().empty()) GTEST_SKIP() << "there is no chromium: install it to open the report in a real browser";
  const Example made = example();
  write_file_whole(folder / "report.html", apps::report_page(text_from_report(made.problem, made.result, made.extra)));

  ASSERT_EQ(open_page("--dump-dom"), 0) << text_of(folder / "browser.log");
  const std::string dom = text_of(folder / "dom.html");
  EXPECT_THAT(dom, HasSubstr("data-drawn=\"yes\""));
  EXPECT_THAT(dom, HasSubstr(fmt::format("<dd>{:.3f} ", made.result.rms_px)));
  for (const char* heading : {"Camera camera0", "Camera camera1", "The rig", "Images without a view (1)"}) {
    EXPECT_THAT(dom, HasSubstr(std::string(">") + heading + "</h")) << heading;
  }

  ASSERT_EQ(open_page("--window-size=1000,2500 --screenshot=page.png"), 0) << text_of(folder / "browser.log");
  const cv::Mat picture = cv::imread((folder / "page.png").string(), cv::IMREAD_GRAYSCALE);
  ASSERT_EQ(picture.size(), cv::Size(1000, 2500));
  // Ink within the first figures; a page without drawings has text on less than a tenth of that.
  const cv::Mat figures = picture(cv::Rect(0, 900, 1000, 1500));
  EXPECT_GT(cv::countNonZero(cv::abs(figures - figures.at<uchar>(0, 0)) > 60), 10000);
}

}  // namespace
}  // namespace raybundle::testing
