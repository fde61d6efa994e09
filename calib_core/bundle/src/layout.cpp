// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "layout.hpp"

#include <algorithm>

namespace raybundle {

Layout::Layout(std::vector<ParameterBlock> all) : blocks(std::move(all)) {
  for (const ParameterBlock& block : blocks) {
    first.push_back(columns);
    free.push_back(block.free());
    columns += static_cast<int>(free.back().size());
  }
}

int Layout::block(ParameterBlock::Kind kind, int owner) const {
  const auto found = std::ranges::find_if(
      blocks, [&](const ParameterBlock& block) { return block.kind == kind && block.owner == owner; });
  return static_cast<int>(found - blocks.begin());
}

std::vector<int> Layout::columns_of(ParameterBlock::Kind kind, int owner) const {
  const int b = block(kind, owner);
  std::vector<int> result(blocks[b].parameters.size(), -1);
  for (std::size_t k = 0; k < free[b].size(); ++k) result[free[b][k]] = first[b] + static_cast<int>(k);
  return result;
}

bool Layout::estimates_lens(int camera) const {
  return !free[block(ParameterBlock::Kind::kIntrinsics, camera)].empty();
}

bool Layout::estimates_shape(int target) const { return !free[block(ParameterBlock::Kind::kShape, target)].empty(); }

Eigen::MatrixXd prior_rows(const Layout& layout, const ParameterBlock& block, const PriorResidual& prior) {
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(prior.residual.size(), layout.columns);
  layout.scatter(block.kind, block.owner, prior.jacobian, rows);
  return rows;
}

}  // namespace raybundle
