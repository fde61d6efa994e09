// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Size of report.html for many views of 140 corners, and the seconds that a headless Chromium takes to open it, the
// median of five times. Bars: 10 MB; a second or two. usage: bench_report [views, default 500]
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "browser.hpp"
#include "judgement.hpp"
#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/io/report_file.hpp"
#include "raybundle/scene/atomic_file.hpp"
#include "report_page.hpp"
#include "synthetic_world.hpp"

namespace {

using namespace raybundle;
namespace fs = std::filesystem;

constexpr double kMostMegabytes = 10.0, kMost_s = 2.0;

std::string page_of(int views) {
  testing::SyntheticOptions options;
  options.frames = views;
  options.columns = 14;
  options.rows = 10;
  options.square_m = 0.025;
  options.noise_px = 0.2;
  const CalibrationProblem problem = testing::synthetic_world(options).problem;
  const CalibrationResult result = calibrate(problem);
  ReportExtra extra;
  extra.sections = apps::sections_of(apps::judge(problem, result, {}, 1), result);
  return apps::report_page(text_from_report(problem, result, extra));
}

double seconds_to_open(testing::Browser& browser, const fs::path& page) {
  std::array<double, 5> seconds;
  for (double& each : seconds) {
    browser.open(page);
    each = browser.evaluate("performance.getEntriesByType('navigation')[0].loadEventEnd / 1000");
  }
  std::ranges::sort(seconds);
  return seconds[seconds.size() / 2];
}

}  // namespace

int main(int argc, char** argv) {
  const int views = argc > 1 ? std::atoi(argv[1]) : 500;
  const fs::path folder = fs::temp_directory_path() / "raybundle_bench_report";
  fs::create_directories(folder);
  write_file_whole(folder / "report.html", page_of(views));
  const double megabytes = static_cast<double>(fs::file_size(folder / "report.html")) / 1e6;
  bool holds = megabytes < kMostMegabytes;
  std::printf("report.html of %d views: %.2f MB (below %.0f: %s)\n", views, megabytes, kMostMegabytes,
              holds ? "holds" : "MISSED");
  if (testing::browser_name().empty()) {
    std::printf("  there is no chromium: install it to see how fast the page opens\n");
  } else {
    testing::Browser browser(folder / "profile");
    const double seconds = seconds_to_open(browser, folder / "report.html");
    holds = holds && seconds <= kMost_s;
    std::printf("  opens in %.2f s (at most %.0f: %s)\n", seconds, kMost_s, seconds <= kMost_s ? "holds" : "MISSED");
  }
  fs::remove_all(folder);
  return holds ? 0 : 1;
}
