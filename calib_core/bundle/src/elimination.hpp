// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "block_system.hpp"
#include "workers.hpp"

namespace raybundle {

/// The members of a BlockSystem that belong to the family of blocks of N unknowns.
template <int N>
BlockFamily<N>& family(BlockSystem& system) {
  if constexpr (N == 6) {
    return system.poses;
  } else {
    return system.shared.beams;
  }
}
template <int N>
const BlockFamily<N>& family(const BlockSystem& system) {
  return family<N>(const_cast<BlockSystem&>(system));
}
template <int N>
int block_of(const PoseBeamBlock& pair) {
  return N == 6 ? pair.pose : pair.beam;
}
template <int N>
const Eigen::Matrix<double, N, 1>& factor_of(const PoseBeamBlock& pair) {
  if constexpr (N == 6) {
    return pair.by_pose;
  } else {
    return pair.by_beam;
  }
}

/// Schur complement of a BlockSystem: the blocks of E unknowns are eliminated, those of K unknowns and the parameters
/// are kept. Every number is summed up by one thread in one order, so that the bits do not depend on their number.
///
/// With the Cholesky factor L of an eliminated block and its rows R in the equations, L⁻¹ R is kept in panels of kTile
/// columns, which hold the rows of those blocks only that meet one of the columns.
template <int E, int K>
class Elimination {
 public:
  using FactorE = Eigen::Matrix<double, E, E>;

  /// @param pattern  whose sizes and pairs of pose and beam count, not its numbers
  explicit Elimination(const BlockSystem& pattern);

  /// Multiplications of one reduce() and factor().
  static double cost(const BlockSystem& pattern);

  /// Eliminates; false when the damped equations of a block are not positive definite.
  ///
  /// @param radius  the diagonal is raised by its 1 / radius
  bool reduce(const BlockSystem& system, double radius, Workers& workers);

  /// After reduce(): eliminates the first kept unknowns too, as eliminate_rows() does; false when their complement is
  /// not positive definite.
  bool factor(int count, Workers& workers);

  /// After reduce() of the same system and factor(kept()).
  BlockStep step(const BlockSystem& system) const;

  int kept() const { return columns_; }  ///< kept unknowns: blocks, then parameters
  int first_parameter() const { return K * kept_blocks_; }

  /// By the kept unknowns, then the gradient; upper triangle.
  const Eigen::MatrixXd& complement() const { return complement_; }

  /// Lower Cholesky factor of an eliminated block.
  const FactorE& block_factor(int block) const { return factors_[block]; }

  /// L⁻¹ times an eliminated block's rows, by the kept unknowns.
  Eigen::Matrix<double, E, Eigen::Dynamic> rows(int block) const;

 private:
  // kTile columns of L⁻¹ R and the eliminated blocks that meet them, ascending.
  struct Panel {
    std::vector<int> blocks;
    std::vector<double> rows;  // E rows of kTile numbers for each of `blocks`
  };

  bool eliminate(const BlockSystem& system, int block);
  void fill_complement(const BlockSystem& system, double radius);
  void subtract(int tile);

  int eliminated_blocks_ = 0;
  int kept_blocks_ = 0;
  int columns_ = 0;
  std::vector<Panel> panels_;                 // of the kept unknowns and the gradient
  std::vector<std::vector<int>> pose_beams_;  // of each eliminated block, indices into BlockSystem::pose_beams
  std::vector<std::vector<double*>> places_;  // of their first row in the panels, aligned with pose_beams_
  std::vector<FactorE> factors_;
  Eigen::Matrix<double, E, Eigen::Dynamic> shifted_;  // L⁻¹ times the gradient, one column for each eliminated block
  Eigen::Matrix<double, E, Eigen::Dynamic> damping_;
  Eigen::VectorXd kept_damping_;
  Eigen::MatrixXd complement_;  // padded by at least a tile
};

extern template class Elimination<6, 4>;
extern template class Elimination<4, 6>;

}  // namespace raybundle
