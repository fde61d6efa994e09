// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/bundle/parameters.hpp"

namespace raybundle {

/// Where the free parameters of each block stand among all free parameters. Board poses are not among them.
struct Layout {
  std::vector<ParameterBlock> blocks;
  std::vector<std::vector<int>> free;  ///< of each block, as ParameterBlock::free
  std::vector<int> first;              ///< column of a block's first free parameter
  int columns = 0;

  explicit Layout(std::vector<ParameterBlock> all);

  /// Index of a block; every camera and every target has all of its blocks.
  int block(ParameterBlock::Kind kind, int owner) const;

  /// Column of each of a block's parameters, -1 for those that are not free.
  std::vector<int> columns_of(ParameterBlock::Kind kind, int owner) const;

  bool estimates_lens(int camera) const;
  bool estimates_shape(int target) const;

  /// Writes the free columns of a block's Jacobian into rows of the whole one.
  template <typename Jacobian, typename Rows>
  void scatter(ParameterBlock::Kind kind, int owner, const Jacobian& jacobian, Rows&& rows) const {
    const int b = block(kind, owner);
    for (std::size_t k = 0; k < free[b].size(); ++k) {
      rows.col(first[b] + static_cast<int>(k)) = jacobian.col(free[b][k]);
    }
  }
};

/// Rows of a block's priors by all free parameters.
Eigen::MatrixXd prior_rows(const Layout& layout, const ParameterBlock& block, const PriorResidual& prior);

}  // namespace raybundle
