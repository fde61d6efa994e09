// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "stereo_frame_input.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "image_files.hpp"
#include "points_json.hpp"
#include "pose_json.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/csv.hpp"
#include "state_name.hpp"
#include "stereo_ply.hpp"

namespace raybundle::apps {
namespace {

namespace fs = std::filesystem;

constexpr int kMostPixels = 1 << 14, kMostOfAll = 1 << 25;  // each way, and in all

[[noreturn]] void damaged(const std::string& path, const std::string& what) {
  throw Error(ErrorKind::kBadInput, what + "; make it again with `raybundle reconstruct stereo`", path);
}

Rectification rectification_of(const nlohmann::json& json, const std::string& path) {
  Rectification pair;
  RectifiedCamera& camera = pair.camera;
  const auto projection = rectified_projection_named(json.at("projection").get<std::string>());
  camera.size = {json.at("width").get<int>(), json.at("height").get<int>()};
  camera.focal_px = json.at("focal_px");
  const std::array<double, 2> centre = json.at("centre_px");
  camera.centre_px = {centre[0], centre[1]};
  pair.baseline_m = json.at("baseline_m");
  pair.rig_from_rectified = pose_from_json(json.at("rig_from_rectified"));
  const bool sized = camera.size.width > 0 && camera.size.width <= kMostPixels && camera.size.height > 0 &&
                     camera.size.height <= kMostPixels && camera.size.width * camera.size.height <= kMostOfAll;
  if (!projection || !sized || !(camera.focal_px > 0) || !(pair.baseline_m > 0) ||
      !(std::abs(pair.rig_from_rectified.rotation.norm() - 1) < 1e-6) ||
      !(pair.rig_from_rectified.translation.norm() < kFarthestPoint_m)) {
    damaged(path, "holds a rectification that cannot be");
  }
  camera.projection = *projection;
  return pair;
}

template <typename Value>
ImageView<const Value> view_of_picture(const cv::Mat& image) {
  return {image.ptr<Value>(), image.cols, image.rows, static_cast<std::ptrdiff_t>(image.step1())};
}

}  // namespace

StereoFrameInput::StereoFrameInput(const std::string& path, bool pictures) {
  read_points_json(path, kStereoPoints, [&](const nlohmann::json& json) {
    state_ = state_named(json.at("state").get<std::string>());
    rectification = rectification_of(json.at("rectification"), path);
    nearest_m = json.at("nearest_m");
    disparity_step_px_ = json.value("disparity_step_px", disparity_step_px_);
    matched_ = json.at("pixels").at("matched");
    if (!(disparity_step_px_ > 0 && disparity_step_px_ <= 1)) damaged(path, "holds an impossible disparity_step_px");
  });
  const std::string stem = fs::path(path).replace_extension().string();
  name = fs::path(stem).filename().string();
  read_points(stem + ".ply");
  if (!pictures) return;
  left_ = picture(stem + "_left.png", CV_8U);
  right_ = picture(stem + "_right.png", CV_8U);
  picture(stem + "_disparity.png", CV_16U).convertTo(disparity_px_, CV_32F, disparity_step_px_);
}

// The rays of the points say which pixels they belong to.
void StereoFrameInput::read_points(const std::string& path) {
  const auto points = points_of_stereo_ply(text_of_file(path));
  if (!points) damaged(path, "is no PLY of points with sigma, or not all of it");
  const RectifiedCamera& camera = rectification.camera;
  points_.resize(static_cast<std::size_t>(camera.size.width) * static_cast<std::size_t>(camera.size.height));
  for (const StereoPoint& point : *points) {
    const Eigen::Vector3d x(point.x_m, point.y_m, point.z_m);
    const auto pixel = camera.pixel_from_ray(x);
    if (!pixel || !camera.contains(*pixel) || !(x.norm() < kFarthestPoint_m) || !(point.sigma_m > 0)) {
      damaged(path, "holds points that the rectified image does not show");
    }
    const auto u = static_cast<std::size_t>(std::floor(pixel->x() + 0.5)),  // from 0: the image contains it
        v = static_cast<std::size_t>(std::floor(pixel->y() + 0.5));
    points_[v * static_cast<std::size_t>(camera.size.width) + u] = point;
  }
}

cv::Mat StereoFrameInput::picture(const std::string& path, int depth) const {
  const cv::Mat image = read_gray(path);
  const ImageSize size = rectification.camera.size;
  if (image.depth() != depth || image.cols != size.width || image.rows != size.height) {
    damaged(path,
            fmt::format("is not the rectified image of {}x{} that belongs to the points", size.width, size.height));
  }
  return image;
}

StereoFrame StereoFrameInput::frame() const {
  const ImageSize size = rectification.camera.size;
  StereoFrame frame;
  frame.state = state_;
  frame.points = {points_.data(), size.width, size.height, size.width};
  frame.disparity.matched = matched_;
  if (left_.empty()) return frame;
  frame.left = view_of_picture<std::uint8_t>(left_);
  frame.right = view_of_picture<std::uint8_t>(right_);
  frame.disparity.disparity_px = view_of_picture<float>(disparity_px_);
  return frame;
}

}  // namespace raybundle::apps
