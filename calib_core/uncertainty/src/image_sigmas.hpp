// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "raybundle/scene/calibration.hpp"

namespace raybundle {

/// How well projections at infinity are known all over a camera's image: looked at once, for hundreds of covariances.
class ImageSigmas {
 public:
  /// @param known   whose names those of the covariances will be
  /// @param across  places in a row of the image
  ImageSigmas(const RigCamera& camera, const Covariance& known, int across);

  /// Of each place, the square of largest_sigma() [px²].
  Eigen::ArrayXd largest_variances(const Eigen::MatrixXd& covariance) const;

 private:
  std::vector<int> estimated_;  ///< places of the lens's parameters in the covariance
  Eigen::MatrixXd products_;  ///< of derivatives by two of them: uu of all places, vv, then uv; a column for each pair
};

}  // namespace raybundle
