// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "calibration_sigma.hpp"
#include "raybundle/stereo/extent.hpp"
#include "raybundle/stereo/rectification.hpp"
#include "raybundle/stereo/stereo.hpp"

namespace raybundle {

/// Triangulates a disparity image. With k = 1 / disparity (pinhole) or cot(disparity / focal) (equirectangular),
///
///   distance = scale[u] k + offset[u],   |d distance / d disparity| = slope[u] (k² + curve)
///   point = distance (x[u], across[u] y[v], across[u] z[v])
class Cloud {
 public:
  Cloud(const Rectification& pair, const CalibrationSigma& calibration);

  /// @param columns   of the row that may be matched; the others become points at 0
  /// @param sigma_px  of each disparity of the row, without the calibration's
  /// @param source    DisparitySource of each; null: all are the matcher's
  void triangulate_row(int v, Extent columns, const float* disparity_px, const float* sigma_px,
                       const std::uint8_t* source, StereoPoint* points) const;

 private:
  bool pinhole_;
  float focal_px_;
  float curve_;
  float relative_baseline_variance_;
  std::vector<float> scale_, offset_, slope_, x_, across_;  // for each column
  std::vector<float> y_, z_;                                // for each row
  std::vector<std::uint8_t> matched_;                       // for each column: DisparitySource::kMatched
  std::vector<float> disparity_variance_;                   // for each pixel, of the calibration [px²]
};

}  // namespace raybundle
