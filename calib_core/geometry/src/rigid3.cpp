// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/geometry/rigid3.hpp"

#include "raybundle/geometry/rotation.hpp"

namespace raybundle {

Rigid3 perturbed(const Rigid3& b_from_a, const Eigen::Matrix<double, 6, 1>& motion) {
  const Eigen::Quaterniond turn(rotation_from_vector(motion.head<3>()));
  return {(turn * b_from_a.rotation).normalized(), b_from_a.translation + motion.tail<3>()};
}

Eigen::Matrix<double, 6, 1> motion_between(const Rigid3& from, const Rigid3& to) {
  Eigen::Matrix<double, 6, 1> motion;
  motion.head<3>() = vector_from_rotation((to.rotation * from.rotation.conjugate()).toRotationMatrix());
  motion.tail<3>() = to.translation - from.translation;
  return motion;
}

double angle_between(const Rigid3& a, const Rigid3& b) { return a.rotation.angularDistance(b.rotation); }

}  // namespace raybundle
