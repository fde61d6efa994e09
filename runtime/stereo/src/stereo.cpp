// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/stereo/stereo.hpp"

#include <vector>

#include "calibration_sigma.hpp"
#include "cloud.hpp"
#include "raybundle/stereo/remap.hpp"
#include "require.hpp"

namespace raybundle {
namespace {

// An image that belongs to the matcher.
template <typename Value>
struct OwnImage {
  ImageSize size;
  std::vector<Value> values;

  explicit OwnImage(ImageSize image_size)
      : size(image_size), values(static_cast<std::size_t>(image_size.width) * image_size.height) {}
  ImageView<Value> view() { return {values.data(), size.width, size.height, size.width}; }
  ImageView<const Value> seen() const { return {values.data(), size.width, size.height, size.width}; }
};

bool of_size(GreyView image, ImageSize size) {
  return image.pixels != nullptr && image.width == size.width && image.height == size.height;
}

}  // namespace

struct StereoMatcher::Data {
  StereoOptions options;
  Rectification pair;
  CalibrationSigma sigma;
  RemapTable left_table, right_table;
  OwnImage<std::uint8_t> left, right;
  Matcher matcher;
  std::optional<DotFusion> fusion;
  Cloud cloud;
  OwnImage<StereoPoint> points;
  int covered = 0;

  Data(const Calibration& calibration, const RigCamera& left_camera, const RigCamera& right_camera,
       const StereoOptions& stereo_options)
      : options(stereo_options),
        pair(rectify(left_camera, right_camera, options.rectify)),
        sigma(calibration_sigma(calibration.covariance, left_camera, right_camera, pair)),
        left_table(remap_table(left_camera.camera, pair.camera, pair.rectified_from_left)),
        right_table(remap_table(right_camera.camera, pair.camera, pair.rectified_from_right)),
        left(pair.camera.size),
        right(pair.camera.size),
        matcher(pair.camera.size, options.match),
        cloud(pair, sigma),
        points(pair.camera.size) {
    if (options.dots) fusion.emplace(pair.camera.size, *options.dots, sigma.disparity_sigma_px);
    for (std::size_t i = 0; i < left_table.covered.size(); ++i) {
      covered += static_cast<int>(left_table.covered[i] & right_table.covered[i]);
    }
    require(covered > 0, "no place is seen by both " + left_camera.name + " and " + right_camera.name +
                             ": they look apart, and nothing can be matched");
  }
};

StereoMatcher::StereoMatcher(const Calibration& calibration, const std::string& left, const std::string& right,
                             const StereoOptions& options)
    : data_(std::make_unique<Data>(calibration, camera_named(calibration, left), camera_named(calibration, right),
                                   options)) {}
StereoMatcher::~StereoMatcher() = default;
StereoMatcher::StereoMatcher(StereoMatcher&&) noexcept = default;
StereoMatcher& StereoMatcher::operator=(StereoMatcher&&) noexcept = default;

const Rectification& StereoMatcher::rectification() const { return data_->pair; }

int StereoMatcher::covered() const { return data_->covered; }

double StereoMatcher::calibration_sigma_px() const {
  const ImageSize size = data_->pair.camera.size;
  return data_->sigma.disparity_sigma_px[static_cast<std::size_t>(size.height / 2) * size.width + size.width / 2];
}

StereoFrame StereoMatcher::process(GreyView left, GreyView right, std::span<const AnchorDot> dots) {
  Data& own = *data_;
  StereoFrame frame;
  if (!of_size(left, own.left_table.source) || !of_size(right, own.right_table.source)) return frame;
  remap(own.left_table, left, own.left.view(), own.options.match.simd);
  remap(own.right_table, right, own.right.view(), own.options.match.simd);
  frame.left = own.left.seen();
  frame.right = own.right.seen();
  frame.disparity =
      own.matcher.match(frame.left, frame.right, own.left_table.covered.data(), own.right_table.covered.data());
  if (own.fusion) frame.fused = own.fusion->fuse(frame.left, frame.disparity, dots);
  for (int v = 0; v < own.points.size.height; ++v) {
    own.cloud.triangulate_row(v, own.left_table.extent(v), frame.disparity_px().row(v), frame.sigma_px().row(v),
                              own.fusion ? frame.fused.source.row(v) : nullptr, own.points.view().row(v));
  }
  frame.points = own.points.seen();
  frame.state = frame.disparity.matched < own.options.least_matched * own.covered ? State::kDegraded : State::kOk;
  return frame;
}

}  // namespace raybundle
