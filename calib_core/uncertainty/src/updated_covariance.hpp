// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace raybundle {

/// U of C = U Uᵀ, for a covariance C that need not be definite.
Eigen::MatrixXd root_of(const Eigen::MatrixXd& covariance);

/// What a covariance U Uᵀ becomes by more information H: (C⁻¹ + H)⁻¹ = U (1 + Uᵀ H U)⁻¹ Uᵀ, without an inverse of C.
///
/// @param whitened_information  Uᵀ H U
Eigen::MatrixXd updated(const Eigen::MatrixXd& root, const Eigen::MatrixXd& whitened_information);

}  // namespace raybundle
