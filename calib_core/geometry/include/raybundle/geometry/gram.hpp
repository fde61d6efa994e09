// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace raybundle {

/// Upper triangle of rowsᵀ rows.
///
/// @param rows  their number is a multiple of 4
void gram(const Eigen::MatrixXd& rows, Eigen::MatrixXd& product);

}  // namespace raybundle
