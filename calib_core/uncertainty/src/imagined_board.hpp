// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/bundle/view_block.hpp"
#include "raybundle/scene/result.hpp"

namespace raybundle {

/// A board of a calibration that is imagined in hundreds of places, with what these have in common.
class ImaginedBoard {
 public:
  /// @param target  index of the calibration, which must outlive this
  ImaginedBoard(const Calibration& calibration, int target);

  /// Points that a camera would see within its image: indices of the board's.
  std::vector<int> seen_by(int camera, const Rigid3& rig_from_target) const;

  /// What all cameras that see enough of the board tell of the parameters that the calibration's covariance names, when
  /// the board's pose may follow freely. Zero when a corner does not project. To the root of the precision of
  /// rows_beside_pose(), which is enough for views that are imagined.
  ///
  /// @param sigma_px  of a corner, by camera
  Eigen::MatrixXd information(const Rigid3& rig_from_target, const std::vector<double>& sigma_px) const;

 private:
  ViewData view_of(int camera, const std::vector<int>& points, double sigma_px) const;

  const Calibration& calibration_;
  int target_;
  std::vector<Eigen::Vector3d> basis_;    ///< as shape_basis()
  std::vector<Eigen::Vector3d> surface_;  ///< the points where the board's shape has them
  std::vector<std::vector<int>> places_;  ///< by camera: of multiply_view()'s columns among the pose's and parameters'
};

}  // namespace raybundle
