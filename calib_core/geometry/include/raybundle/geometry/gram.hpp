// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace raybundle {

inline constexpr Eigen::Index kGramRows = 4;

/// The next multiple of kGramRows.
inline Eigen::Index padded_for_gram(Eigen::Index rows) { return (rows + kGramRows - 1) / kGramRows * kGramRows; }

/// Upper triangle of rowsᵀ rows.
///
/// @param rows   their number is a multiple of kGramRows
/// @param first  of the columns that are taken
void gram(const Eigen::MatrixXd& rows, Eigen::MatrixXd& product, int first = 0);

}  // namespace raybundle
