// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>

#include <opencv2/core/version.hpp>

#include <CLI/Version.hpp>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <filesystem>
#include <thread>

#include "detection_cache.hpp"
#include "media/media.hpp"
#include "raybundle/camera/camera.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/targets/board_kind.hpp"
#include "raybundle/uncertainty/second_opinion.hpp"
#include "terminal.hpp"
#include "verbs.hpp"

namespace raybundle::apps {
namespace {

constexpr const char* kDemoImages = "/usr/share/doc/opencv-doc/examples/data/left01.jpg";

// Whether a command is on the path.
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

// What is missing, what for, and how to get it.
struct Missing {
  std::string what, without_it, remedy;
};

// A folder in which a file can be made, or the nearest one above it that is there.
bool can_be_written(std::filesystem::path folder) {
  std::error_code ignored;
  while (!folder.empty() && !std::filesystem::exists(folder, ignored)) folder = folder.parent_path();
  return ::access(folder.empty() ? "." : folder.c_str(), W_OK | X_OK) == 0;
}

// Of OpenCV's readers.
void add_missing_readers(std::vector<Missing>& missing) try {
  if (media().reads_videos()) return;
  missing.push_back({"OpenCV's video backend", "images can be read, videos cannot",
                     "sudo apt-get install libopencv-videoio-dev, and build again"});
} catch (const Error& error) {
  missing.push_back({kMediaLibrary, "JPEG and grey PNG can be read, other images and videos cannot", error.what()});
}

std::vector<Missing> missing_things() {
  std::vector<Missing> missing;
  const bool browser = std::ranges::any_of(std::array{"chromium", "firefox", "firefox-esr", "google-chrome"},
                                           [](const char* name) { return have_command(name); });
  if (!browser) {
    missing.push_back(
        {"a web browser", "report.html can only be looked at on another machine", "sudo apt-get install firefox-esr"});
  }
  add_missing_readers(missing);
  if (!std::filesystem::exists(kDemoImages)) {
    missing.push_back({"the images of `raybundle demo`", "all else works; ./dev demo unpacks them by itself",
                       "sudo apt-get install opencv-doc"});
  }
  if (!second_opinion_available()) {
    missing.push_back({"mrcal", "`calibrate --second-opinion` has nobody to ask",
                       "sudo apt-get install libmrcal-dev, and build again"});
  }
  if (!can_be_written(cache_folder())) {
    missing.push_back({"a folder for the detection cache", "every run looks at all images again",
                       "make " + cache_folder() + " writable, or set XDG_CACHE_HOME to a folder that is"});
  }
  return missing;
}

// The cache, and what it holds.
std::string cache_text() {
  std::error_code failed;
  std::size_t images = 0;
  double bytes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(cache_folder(), failed)) {
    std::error_code gone;  // another run may be at work
    const auto size = entry.file_size(gone);
    if (gone) continue;
    ++images;
    bytes += static_cast<double>(size);
  }
  if (images == 0) return cache_folder() + " (empty)";
  return fmt::format("{} ({} images, {:.1f} MB; unused for {} days they are deleted; delete the folder to empty it)",
                     cache_folder(), images, bytes / 1e6, kDaysInCache);
}

void run() {
  std::string models, kinds;
  for (std::string_view name : model_names()) models += fmt::format("{}{}", models.empty() ? "" : ", ", name);
  for (const BoardKind& kind : board_kinds()) kinds += (kinds.empty() ? "" : ", ") + kind.name;
  const std::vector<std::pair<std::string, std::string>> rows{
      {"raybundle", RAYBUNDLE_VERSION},
      {"OpenCV", CV_VERSION},
      {"Eigen", fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
      {"camera models", models},
      {"boards", kinds},
      {"processors", fmt::format("{}", std::thread::hardware_concurrency())},
      {"detection cache", cache_text()}};
  for (const auto& [what, is] : rows) fmt::print("{:<16} {}\n", what, is);
  const std::vector<Missing> missing = missing_things();
  fmt::print("\n{}\n", missing.empty() ? "nothing is missing" : "missing, though calibrating works without:");
  for (const Missing& each : missing) {
    fmt::print("  {}: {}\n    {}\n", each.what, each.without_it, each.remedy);
  }
}

}  // namespace

void add_doctor_verb(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("doctor", "what is installed and what is missing");
  verb->footer("Example:\n  raybundle doctor");
  verb->callback(run);
}

}  // namespace raybundle::apps
