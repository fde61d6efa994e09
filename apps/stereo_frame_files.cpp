// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "stereo_frame_files.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "former_frames.hpp"
#include "image_codec.hpp"
#include "page_text.hpp"
#include "points_json.hpp"
#include "pose_json.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/quantile.hpp"
#include "state_name.hpp"
#include "stereo_ply.hpp"
#include "terminal.hpp"

namespace raybundle::apps {
namespace {

namespace fs = std::filesystem;

constexpr const char* kEndings[] = {"_left.png", "_right.png", "_disparity.png", "_depth.png", ".ply", ".json"};

std::string png_of_view(GreyView image) {
  return png_from(cv::Mat(image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.pixels),
                          static_cast<std::size_t>(image.stride)));
}

// What the depth image holds: z of a pinhole pair, the distance from the camera of an equirectangular one.
double depth_of(const StereoPoint& point, RectifiedProjection projection) {
  if (projection == RectifiedProjection::kPinhole) return point.z_m;
  return std::sqrt(point.x_m * point.x_m + point.y_m * point.y_m + point.z_m * point.z_m);
}

template <typename Value>
std::string png_of_values(const StereoFrame& frame, Value&& value) {
  cv::Mat image(frame.points.height, frame.points.width, CV_16U);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const double units = std::round(value(u, v));
      image.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(units > 0 && units < 65536 ? units : 0);
    }
  }
  return png_from(image);
}

// The step of the disparity image: 1/256 px, or the finest twice, four times, ... as coarse in which 16 bits hold all
// disparities of the frame.
double disparity_step_px(ImageView<const float> disparity_px) {
  float most_px = 0;
  for (int v = 0; v < disparity_px.height; ++v) {
    for (int u = 0; u < disparity_px.width; ++u) most_px = std::max(most_px, disparity_px.at(u, v));
  }
  double step_px = 1.0 / 256;
  while (std::round(most_px / step_px) > 65535) step_px *= 2;
  return step_px;
}

nlohmann::ordered_json rectification_json(const Rectification& pair) {
  constexpr double kDegrees = 180.0 / M_PI;
  nlohmann::ordered_json json;
  json["projection"] = rectified_projection_name(pair.camera.projection);
  json["width"] = pair.camera.size.width;
  json["height"] = pair.camera.size.height;
  json["focal_px"] = pair.camera.focal_px;
  json["centre_px"] = {pair.camera.centre_px.x(), pair.camera.centre_px.y()};
  json["baseline_m"] = pair.baseline_m;
  json["field_deg"] = {pair.field_x_rad * kDegrees, pair.field_y_rad * kDegrees};
  json["kept"] = {{"left", pair.kept_left}, {"right", pair.kept_right}};
  json["rig_from_rectified"] = json_from_pose(pair.rig_from_rectified);
  return json;
}

}  // namespace

StereoFrameFiles stereo_frame_files(const StereoFrame& frame, const StereoMatcher& matcher, const std::string& left,
                                    const std::string& right, const nlohmann::ordered_json& more) {
  const RectifiedProjection projection = matcher.rectification().camera.projection;
  std::vector<double> depths, sigmas;
  std::array<int, kMatchKinds> kinds{};
  for (int v = 0; v < frame.points.height; ++v) {
    for (int u = 0; u < frame.points.width; ++u) {
      ++kinds[frame.disparity.match.at(u, v)];
      const StereoPoint& point = frame.points.at(u, v);
      if (point.sigma_m == 0) continue;
      depths.push_back(depth_of(point, projection));
      sigmas.push_back(point.sigma_m);
    }
  }
  nlohmann::ordered_json json{{"format", kStereoPoints.name}, {"version", 1}};
  json["left"] = left;
  json["right"] = right;
  json["state"] = state_name(frame.state);
  json["points"] = depths.size();
  json["covered"] = matcher.covered();
  for (int kind = 0; kind < kMatchKinds; ++kind) {
    json["pixels"][std::string(match_name(static_cast<Match>(kind)))] = kinds[static_cast<std::size_t>(kind)];
  }
  const double step_px = disparity_step_px(frame.disparity_px());
  json["disparity_step_px"] = step_px;
  json["depth"] = projection == RectifiedProjection::kPinhole ? "z" : "distance";
  if (!depths.empty()) {
    json["depth_m"] = {{"p05", quantile(depths, 0.05)}, {"median", median(depths)}, {"p95", quantile(depths, 0.95)}};
    json["sigma_m"] = {{"median", median(sigmas)}};
  }
  json["calibration_sigma_px"] = matcher.calibration_sigma_px();
  json["rectification"] = rectification_json(matcher.rectification());
  json.update(more);
  return {png_of_view(frame.left),
          png_of_view(frame.right),
          png_of_values(frame, [&](int u, int v) { return frame.disparity_px().at(u, v) / step_px; }),
          png_of_values(frame, [&](int u, int v) { return 1000.0 * depth_of(frame.points.at(u, v), projection); }),
          stereo_ply(frame),
          text_of_json(json, 1) + "\n"};
}

std::vector<WholeFile> named_files(const fs::path& folder, const std::string& name, const StereoFrameFiles& files) {
  const std::string_view bytes[] = {files.left_png,  files.right_png, files.disparity_png,
                                    files.depth_png, files.ply,       files.json};
  static_assert(std::size(bytes) == std::size(kEndings));
  std::vector<WholeFile> named;
  for (std::size_t i = 0; i < std::size(kEndings); ++i) named.push_back({folder / (name + kEndings[i]), bytes[i]});
  return named;
}

void remove_former_stereo_frames(const fs::path& folder, const std::set<std::string>& names) {
  remove_former_frames(folder, kStereoPoints, kEndings, names);
}

}  // namespace raybundle::apps
