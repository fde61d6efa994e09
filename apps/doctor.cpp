// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <ceres/version.h>
#include <fmt/format.h>
#include <opencv2/core/version.hpp>

#include <CLI/Version.hpp>
#include <Eigen/Core>
#include <filesystem>
#include <thread>

#include "detection_cache.hpp"
#include "raybundle/camera/camera.hpp"
#include "raybundle/targets/board_kind.hpp"
#include "terminal.hpp"
#include "verbs.hpp"

namespace raybundle::apps {
namespace {

// Whether a command is on the path: what it would add is said when it is not.
bool have_command(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::string rest = path == nullptr ? "" : path;
  while (!rest.empty()) {
    const std::size_t colon = rest.find(':');
    std::error_code ignored;
    if (std::filesystem::exists(std::filesystem::path(rest.substr(0, colon)) / name, ignored)) return true;
    rest = colon == std::string::npos ? "" : rest.substr(colon + 1);
  }
  return false;
}

void run() {
  std::string models, kinds;
  for (std::string_view name : model_names()) models += fmt::format("{}{}", models.empty() ? "" : ", ", name);
  for (const BoardKind& kind : board_kinds()) kinds += (kinds.empty() ? "" : ", ") + kind.name;
  std::error_code ignored;
  const bool cached = std::filesystem::exists(cache_folder(), ignored);
  std::vector<std::vector<std::string>> rows{
      {"raybundle", RAYBUNDLE_VERSION},
      {"Ceres Solver", CERES_VERSION_STRING},
      {"OpenCV", CV_VERSION},
      {"Eigen", fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
      {"camera models", models},
      {"boards", kinds},
      {"processors", fmt::format("{}", std::thread::hardware_concurrency())},
      {"detection cache", cache_folder() + (cached ? "" : " (empty)")}};
  for (const char* browser : {"chromium", "firefox"}) {
    if (have_command(browser)) rows.push_back({"browser for reports", browser});
  }
  fmt::print("{}", text_table(rows));
}

}  // namespace

void add_doctor_verb(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("doctor", "what is installed and what is missing");
  verb->callback(run);
}

}  // namespace raybundle::apps
