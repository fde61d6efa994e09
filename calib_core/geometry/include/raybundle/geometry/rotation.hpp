// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace raybundle {

/// Cross-product matrix: skew(a) b = a × b.
Eigen::Matrix3d skew(const Eigen::Vector3d& a);

/// Rotation matrix of a rotation vector (axis times angle [rad]). Source: Rodrigues' formula.
Eigen::Matrix3d rotation_from_vector(const Eigen::Vector3d& rotation_vector);

/// Rotation vector (axis times angle [rad], angle in [0, pi]) of a rotation matrix.
Eigen::Vector3d vector_from_rotation(const Eigen::Matrix3d& rotation);

/// Rotation nearest to a matrix in the Frobenius norm. Source: Schönemann 1966, orthogonal Procrustes problem.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& matrix);

}  // namespace raybundle
