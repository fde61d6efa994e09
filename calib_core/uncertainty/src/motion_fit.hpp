// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace raybundle {

/// The motion of the surroundings that undoes changes of the image, by weighted least squares over pixels.
struct MotionFit {
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, Eigen::Dynamic> with_changes;

  /// @param changes  how many changes are undone, each by a motion of its own
  explicit MotionFit(Eigen::Index changes) { with_changes.setZero(6, changes); }

  /// @param by_motion  of the pixel
  /// @param change     2 × changes, of the pixel
  void add(const Eigen::Matrix<double, 2, 6>& by_motion, const Eigen::Ref<const Eigen::MatrixXd>& change,
           double weight) {
    normal += weight * by_motion.transpose() * by_motion;
    with_changes += weight * by_motion.transpose() * change;
  }

  /// The same of many pixels, two rows for each, by the roots of their weights.
  template <typename Motion, typename Changes>
  void add(const Eigen::MatrixBase<Motion>& by_motion, const Eigen::MatrixBase<Changes>& changes) {
    normal.noalias() += by_motion.transpose() * by_motion;
    with_changes.noalias() += by_motion.transpose() * changes;
  }

  /// The same fit for another motion, of which `map` makes the one that it was made for.
  void change_motion(const Eigen::Matrix<double, 6, 6>& map) {
    normal = map.transpose() * normal * map;
    with_changes = map.transpose() * with_changes;
  }

  /// 6 × changes; directions that no pixel tells from standing still stay zero.
  Eigen::Matrix<double, 6, Eigen::Dynamic> undoing() const;
};

/// How a pixel moves with the motion of a point at a range along a ray; translations do not move infinitely far ones.
Eigen::Matrix<double, 2, 6> by_motion_at(const Eigen::Matrix<double, 2, 3>& by_ray, const Eigen::Vector3d& ray,
                                         double range_m);

}  // namespace raybundle
