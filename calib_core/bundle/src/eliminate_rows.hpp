// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "workers.hpp"

namespace raybundle {

/// The first steps of a Cholesky factorisation, with the same bits for every number of threads: replaces the first
/// `count` rows by those of the upper factor U, up to the last column, and what is behind them by its Schur complement.
///
/// @param matrix   upper triangle; larger than `columns` by at least kTile
/// @param columns  that mean something
/// @return         false when the first `count` rows and columns are not positive definite
bool eliminate_rows(Eigen::MatrixXd& matrix, int count, int columns, Workers& workers);

}  // namespace raybundle
