// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "raybundle/device/image_view.hpp"
#include "raybundle/device/state.hpp"
#include "raybundle/scene/calibration.hpp"
#include "raybundle/stereo/dot_fusion.hpp"
#include "raybundle/stereo/matcher.hpp"
#include "raybundle/stereo/rectification.hpp"

namespace raybundle {

/// A point that a pixel of the left rectified image shows.
struct StereoPoint {
  float x_m = 0.0F;  ///< in the rectified frame: x along the baseline, y down, z forward, from the left camera
  float y_m = 0.0F;
  float z_m = 0.0F;
  /// Standard deviation along the ray; 0 where there is no point. Of match and calibration, or of the dots alone, whose
  /// distance the pair's calibration does not change.
  float sigma_m = 0.0F;
};

struct StereoOptions {
  RectifyOptions rectify;
  MatchOptions match;
  double least_matched = 0.05;           ///< share of the covered pixels below which a frame is degraded
  std::optional<DotFusionOptions> dots;  ///< set: laser dots may be given
};

/// What one pair of images gave. The views belong to the matcher and hold until its next call.
struct StereoFrame {
  State state = State::kInvalid;        ///< kInvalid: an image is not of the calibrated size; nothing else is set then
  GreyView left;                        ///< rectified
  GreyView right;                       ///< rectified
  DisparityView disparity;              ///< the matcher's
  FusedView fused;                      ///< with the dots; no pixels when the options have none
  ImageView<const StereoPoint> points;  ///< organised: one for each pixel of `left`

  /// What the points were made of: fused, or the matcher's.
  ImageView<const float> disparity_px() const {
    return fused.disparity_px.pixels != nullptr ? fused.disparity_px : disparity.disparity_px;
  }
  ImageView<const float> sigma_px() const {
    return fused.sigma_px.pixels != nullptr ? fused.sigma_px : disparity.sigma_px;
  }
};

/// From two camera images to points: rectifies, matches, and triangulates. All memory is taken by the constructor;
/// process() takes none, throws nothing, and gives the same bits on every run and machine.
class StereoMatcher {
 public:
  /// @throws Error(kBadInput) as rectify() and Matcher do, or when there is no camera of a name
  StereoMatcher(const Calibration& calibration, const std::string& left, const std::string& right,
                const StereoOptions& options = {});
  ~StereoMatcher();
  StereoMatcher(StereoMatcher&&) noexcept;
  StereoMatcher& operator=(StereoMatcher&&) noexcept;

  const Rectification& rectification() const;

  /// Pixels that both cameras show: no more can be matched.
  int covered() const;

  /// Standard deviation of the disparity that the calibration alone causes, at the middle of the image [px].
  double calibration_sigma_px() const;

  /// @param left, right  as the cameras took them, at one moment
  /// @param dots         of that moment; without StereoOptions::dots they do not matter
  StereoFrame process(GreyView left, GreyView right, std::span<const AnchorDot> dots = {});

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace raybundle
