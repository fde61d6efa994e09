// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "simulated_images.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "image_codec.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/threads.hpp"
#include "raybundle/scene/atomic_file.hpp"
#include "terminal.hpp"

namespace raybundle::apps {
namespace {

namespace fs = std::filesystem;

cv::Mat mat_of(const GreyImage& image) {
  cv::Mat mat(image.size.height, image.size.width, image.bits == 8 ? CV_8U : CV_16U);
  const unsigned largest = (1u << image.bits) - 1, white = image.bits == 8 ? 255 : 65535;
  for (int y = 0; y < mat.rows; ++y) {
    for (int x = 0; x < mat.cols; ++x) {
      const unsigned value = (image.at(x, y) * white + largest / 2) / largest;
      if (image.bits == 8) {
        mat.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(value);
      } else {
        mat.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(value);
      }
    }
  }
  return mat;
}

bool is_simulated_image(const fs::path& path) {
  const std::string name = path.filename().string();
  const std::size_t digits = std::min(name.find_first_not_of("0123456789"), name.size());
  return digits > 0 && (name.substr(digits) == "_on.png" || name.substr(digits) == "_off.png");
}

fs::path folder_of(const fs::path& folder, const SimulatedCamera& camera) {
  return (folder / simulated_image(camera.name, 0, false)).parent_path();
}

[[noreturn]] void refuse_folder(const fs::path& folder, const std::error_code& error) {
  throw Error(ErrorKind::kIo, fmt::format("the folder {} for images cannot be prepared: {}; choose another with -o",
                                          folder.string(), error.message()));
}

bool names_a_folder(const SimulatedCamera& camera) {
  return camera.name.find_first_of("/\\*?[") == std::string::npos && camera.name != "." && camera.name != "..";
}

}  // namespace

void write_png(const fs::path& path, const GreyImage& image) { write_file_whole(path, png_from(mat_of(image))); }

std::string simulated_image(const std::string& camera, const std::string& frame, bool laser) {
  return fmt::format("images/{}/{}_{}.png", camera, frame, laser ? "on" : "off");
}

std::string simulated_image(const std::string& camera, int frame, bool laser) {
  return simulated_image(camera, fmt::format("{:03}", frame), laser);
}

void require_images(const BoardedRig& boarded) {
  if (std::holds_alternative<PointSet>(boarded.board)) {
    throw Error(ErrorKind::kBadInput, "a board of kind \"points\" has no print to render; add --no-images");
  }
  for (const SimulatedCamera& camera : boarded.rig.cameras) {
    if (names_a_folder(camera)) continue;
    throw Error(ErrorKind::kBadInput,
                fmt::format("camera '{}' cannot name a folder of images; rename it, or add --no-images", camera.name));
  }
}

void remove_former_images(const fs::path& folder, const std::vector<SimulatedCamera>& cameras) {
  std::vector<fs::path> former;
  for (const SimulatedCamera& camera : cameras) {
    const fs::path images = folder_of(folder, camera);
    std::error_code error;
    if (!names_a_folder(camera) || !fs::is_directory(images, error)) continue;
    for (const auto& entry : fs::directory_iterator(images, error)) {
      if (is_simulated_image(entry.path())) former.push_back(entry.path());
    }
    if (error) refuse_folder(images, error);
  }
  for (const fs::path& path : former) {
    std::error_code error;
    fs::remove(path, error);
    if (error) refuse_folder(path.parent_path(), error);
  }
  if (former.empty()) return;
  say(fmt::format("removed {} image{} of a former run from {}", former.size(), former.size() == 1 ? "" : "s",
                  folder.string()));
}

void write_images(const fs::path& folder, const BoardedRig& boarded, const Simulation& simulation,
                  const SimulateOptions& options, int threads) {
  const std::vector<SimulatedCamera>& cameras = boarded.rig.cameras;
  for (const SimulatedCamera& camera : cameras) {
    std::error_code error;
    fs::create_directories(folder_of(folder, camera), error);
    if (error) refuse_folder(folder_of(folder, camera), error);
  }
  const ViewRenderer renderer(boarded.rig, options.warmer_K);
  const std::size_t count = simulation.poses.size() * cameras.size();
  Progress progress("rendering", static_cast<int>(count));
  std::mutex guard;  // of the progress
  for_each_index(count, threads, [&](std::size_t i) {
    const BoardPose& pose = simulation.poses[i / cameras.size()];
    const std::size_t c = i % cameras.size();
    const RenderedView view =
        renderer.render(static_cast<int>(c), pose.rig_from_target, {.seed = options.seed, .stream = i});
    write_png(folder / simulated_image(cameras[c].name, pose.frame, false), view.off);
    if (boarded.rig.emitter) write_png(folder / simulated_image(cameras[c].name, pose.frame, true), view.on);
    const std::scoped_lock lock(guard);
    progress.advance();
  });
}

}  // namespace raybundle::apps
