// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "raybundle/geometry/rigid3.hpp"

namespace raybundle {

/// A transform as other programs and NumPy's users write it: 4×4, b_from_a.
Eigen::Matrix4d matrix_from_rigid3(const Rigid3& b_from_a);

/// The transform of a matrix whose digits were rounded.
///
/// @param rounding  most that rotationᵀ rotation may be off the identity (Frobenius norm)
/// @return          nothing when the matrix is no rotation
std::optional<Rigid3> rigid3_from_matrix(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation,
                                         double rounding);

}  // namespace raybundle
