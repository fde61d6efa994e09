// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "stereo_page.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "image_codec.hpp"
#include "page_parts.hpp"
#include "page_text.hpp"
#include "raybundle/geometry/quantile.hpp"
#include "state_name.hpp"

namespace raybundle::apps {
namespace {

constexpr int kPageWidth = 640;     // of pictures [px]
constexpr int kPagePoints = 12000;  // of a frame, about

// An image as wide as the page shows it.
cv::Mat for_page(cv::Mat image) {
  const double scale = std::min(1.0, static_cast<double>(kPageWidth) / image.cols);
  if (scale < 1.0) cv::resize(image, image, {}, scale, scale, cv::INTER_NEAREST);
  return image;
}

template <typename Value>
cv::Mat image_of(ImageView<const Value> view, int type) {
  return {view.height, view.width, type, const_cast<Value*>(view.pixels),
          static_cast<std::size_t>(view.stride) * sizeof(Value)};
}

// Nearest red, farthest blue.
cv::Mat coloured(ImageView<const float> disparity_px) {
  const cv::Mat values = image_of(disparity_px, CV_32F);
  double most = 0.0;
  cv::minMaxLoc(values, nullptr, &most);
  cv::Mat bytes, colours;
  values.convertTo(bytes, CV_8U, 255.0 / std::max(most, 1.0));
  cv::applyColorMap(bytes, colours, cv::COLORMAP_TURBO);
  colours.setTo(0, values == 0);
  return colours;
}

}  // namespace

nlohmann::json stereo_page_frame(const std::string& name, const StereoFrame& frame) {
  nlohmann::json points = nlohmann::json::array();
  std::array<std::vector<double>, 3> places;
  const int every = std::max(1, frame.disparity.matched / kPagePoints);
  const auto rounded = [](float metres) { return std::round(1e3 * static_cast<double>(metres)) / 1e3; };
  int matched = 0;
  for (int v = 0; v < frame.points.height; ++v) {
    for (int u = 0; u < frame.points.width; ++u) {
      const StereoPoint& point = frame.points.at(u, v);
      if (point.sigma_m == 0 || matched++ % every != 0) continue;
      points.insert(points.end(), {rounded(point.x_m), rounded(point.y_m), rounded(point.z_m), frame.left.at(u, v)});
      places[0].push_back(point.x_m);
      places[1].push_back(point.y_m);
      places[2].push_back(point.z_m);
    }
  }
  const auto middle = [](std::vector<double>& values) { return values.empty() ? 1.0 : median(values); };
  return {{"name", name},
          {"state", state_name(frame.state)},
          {"matched", frame.disparity.matched},
          {"middle_m", {middle(places[0]), middle(places[1]), middle(places[2])}},
          {"left", base64(jpeg_from(for_page(image_of(frame.left, CV_8U))))},
          {"right", base64(jpeg_from(for_page(image_of(frame.right, CV_8U))))},
          {"disparity", base64(png_from(for_page(coloured(frame.disparity_px()))))},
          {"points", std::move(points)}};
}

std::string stereo_page(const nlohmann::json& frames) {
  return filled(kStereoPage, "data", json_for_script(text_of_json(frames)));
}

}  // namespace raybundle::apps
