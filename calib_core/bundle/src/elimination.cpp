// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "elimination.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <atomic>
#include <numeric>

#include "eliminate_rows.hpp"
#include "tiles.hpp"

namespace raybundle {

template <int E, int K>
Elimination<E, K>::Elimination(const BlockSystem& pattern)
    : eliminated_blocks_(family<E>(pattern).blocks()),
      kept_blocks_(family<K>(pattern).blocks()),
      columns_(K * kept_blocks_ + pattern.parameters()),
      panels_(columns_ / kTile + 1),
      pose_beams_(eliminated_blocks_),
      places_(eliminated_blocks_),
      factors_(eliminated_blocks_),
      shifted_(E, eliminated_blocks_),
      damping_(E, eliminated_blocks_) {
  for (int t = 0; t < static_cast<int>(pattern.pose_beams.size()); ++t) {
    const PoseBeamBlock& pair = pattern.pose_beams[t];
    pose_beams_[block_of<E>(pair)].push_back(t);
    panels_[K * block_of<K>(pair) / kTile].blocks.push_back(block_of<E>(pair));
  }
  for (std::size_t p = 0; p < panels_.size(); ++p) {
    std::vector<int>& blocks = panels_[p].blocks;
    if (static_cast<int>(p + 1) * kTile > first_parameter()) {
      blocks.resize(eliminated_blocks_);
      std::iota(blocks.begin(), blocks.end(), 0);
    }
    std::ranges::sort(blocks);
    blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
    blocks.shrink_to_fit();
    panels_[p].rows.assign(blocks.size() * E * kTile, 0.0);
  }
  for (int block = 0; block < eliminated_blocks_; ++block) {
    for (int t : pose_beams_[block]) {
      const int column = K * block_of<K>(pattern.pose_beams[t]);
      Panel& panel = panels_[column / kTile];
      const auto position = std::ranges::lower_bound(panel.blocks, block) - panel.blocks.begin();
      places_[block].push_back(panel.rows.data() + position * E * kTile + column % kTile);
    }
  }
}

template <int E, int K>
double Elimination<E, K>::cost(const BlockSystem& pattern) {
  std::vector<double> met(family<E>(pattern).blocks(), pattern.parameters());  // kept unknowns, by eliminated block
  for (const PoseBeamBlock& pair : pattern.pose_beams) met[block_of<E>(pair)] += K;
  const double kept = K * family<K>(pattern).blocks() + pattern.parameters();
  double products = kept * kept * kept / 6.0;
  for (const double unknowns : met) products += 0.5 * E * unknowns * unknowns;
  return products;
}

template <int E, int K>
bool Elimination<E, K>::eliminate(const BlockSystem& system, int block) {
  const BlockFamily<E>& own = family<E>(system);
  FactorE matrix = own.own.template middleCols<E>(E * block);
  matrix.diagonal() += damping_.col(block);
  const Eigen::LLT<FactorE> llt(matrix);
  if (llt.info() != Eigen::Success) return false;
  factors_[block] = llt.matrixL();
  const auto lower = factors_[block].template triangularView<Eigen::Lower>();
  for (std::size_t i = 0; i < pose_beams_[block].size(); ++i) {
    const PoseBeamBlock& pair = system.pose_beams[pose_beams_[block][i]];
    const Eigen::Matrix<double, E, 1> solved = lower.solve(factor_of<E>(pair));
    const Eigen::Matrix<double, K, 1>& right = factor_of<K>(pair);
    double* place = places_[block][i];
    for (int r = 0; r < E; ++r) {
      for (int c = 0; c < K; ++c) place[r * kTile + c] = solved[r] * right[c];
    }
  }
  const auto fill = [&](int column, const Eigen::Matrix<double, E, 1>& solved) {
    double* place = panels_[column / kTile].rows.data() + block * E * kTile + column % kTile;
    for (int r = 0; r < E; ++r) place[r * kTile] = solved[r];
  };
  const int parameters = system.parameters();
  for (int q = 0; q < parameters; ++q) {
    fill(first_parameter() + q, lower.solve(own.with_parameters.col(block * parameters + q)));
  }
  shifted_.col(block) = lower.solve(own.gradient.col(block));
  fill(columns_, shifted_.col(block));
  return true;
}

template <int E, int K>
void Elimination<E, K>::fill_complement(const BlockSystem& system, double radius) {
  const auto size = static_cast<Eigen::Index>(panels_.size() + 1) * kTile;
  const int parameters = system.parameters();
  const BlockFamily<K>& kept = family<K>(system);
  complement_.setZero(size, size);
  for (int b = 0; b < kept_blocks_; ++b) {
    complement_.block<K, K>(K * b, K * b) = kept.own.template middleCols<K>(K * b);
    complement_.block(K * b, first_parameter(), K, parameters) =
        kept.with_parameters.middleCols(static_cast<Eigen::Index>(b) * parameters, parameters);
    complement_.template block<K, 1>(K * b, columns_) = kept.gradient.col(b);
  }
  complement_.block(first_parameter(), first_parameter(), parameters, parameters) = system.shared.matrix;
  complement_.block(first_parameter(), columns_, parameters, 1) = system.shared.gradient;
  kept_damping_.resize(columns_);
  for (int c = 0; c < columns_; ++c) kept_damping_[c] = damping(complement_(c, c), radius);
  complement_.diagonal().head(columns_) += kept_damping_;
}

template <int E, int K>
void Elimination<E, K>::subtract(int tile) {
  const TilePlace place = tile_place(tile);
  const Panel& left = panels_[place.row];
  const Panel& right = panels_[place.column];
  thread_local std::vector<TileRows> common;
  common.clear();
  for (std::size_t l = 0, r = 0; l < left.blocks.size() && r < right.blocks.size();) {
    if (left.blocks[l] == right.blocks[r]) {
      common.push_back({left.rows.data() + l * E * kTile, right.rows.data() + r * E * kTile});
    }
    const bool next_left = left.blocks[l] <= right.blocks[r];
    const bool next_right = left.blocks[l] >= right.blocks[r];
    l += next_left;
    r += next_right;
  }
  subtract_products(common, E, &complement_(place.row * kTile, place.column * kTile), complement_.rows());
}

template <int E, int K>
bool Elimination<E, K>::reduce(const BlockSystem& system, double radius, Workers& workers) {
  for (int b = 0; b < eliminated_blocks_; ++b) {
    for (int k = 0; k < E; ++k) damping_(k, b) = damping(family<E>(system).own(k, E * b + k), radius);
  }
  std::atomic<bool> definite = true;
  workers.for_each(eliminated_blocks_, [&](int block) {
    if (!eliminate(system, block)) definite = false;
  });
  if (!definite) return false;
  fill_complement(system, radius);
  const int panels = static_cast<int>(panels_.size());
  workers.for_each(panels * (panels + 1) / 2, [&](int tile) { subtract(tile); });
  return true;
}

template <int E, int K>
bool Elimination<E, K>::factor(int count, Workers& workers) {
  return eliminate_rows(complement_, count, columns_ + 1, workers);
}

template <int E, int K>
BlockStep Elimination<E, K>::step(const BlockSystem& system) const {
  // The factor U went over the gradient, too: U⁻ᵀ g stands in its column.
  Eigen::VectorXd kept = -complement_.col(columns_).head(columns_);
  const double kept_decrease = kept.squaredNorm();
  complement_.topLeftCorner(columns_, columns_).template triangularView<Eigen::Upper>().solveInPlace(kept);

  BlockStep step;
  step.parameters = kept.tail(system.parameters());
  Eigen::Matrix<double, K, Eigen::Dynamic> kept_blocks =
      kept.head(first_parameter()).reshaped(K, static_cast<Eigen::Index>(kept_blocks_));
  Eigen::Matrix<double, E, Eigen::Dynamic> eliminated(E, eliminated_blocks_);
  const BlockFamily<E>& own = family<E>(system);
  const int parameters = system.parameters();
  for (int block = 0; block < eliminated_blocks_; ++block) {
    Eigen::Matrix<double, E, 1> right = own.gradient.col(block);
    right +=
        own.with_parameters.middleCols(static_cast<Eigen::Index>(block) * parameters, parameters) * step.parameters;
    for (int t : pose_beams_[block]) {
      const PoseBeamBlock& pair = system.pose_beams[t];
      right += factor_of<K>(pair).dot(kept_blocks.col(block_of<K>(pair))) * factor_of<E>(pair);
    }
    const auto lower = factors_[block].template triangularView<Eigen::Lower>();
    lower.solveInPlace(right);
    lower.transpose().solveInPlace(right);
    eliminated.col(block) = -right;
  }
  // With the gradient g and the damping D: (H + D) step = -g, hence -gᵀ step - stepᵀ H step / 2 is this.
  const double damped_square =
      (damping_.array() * eliminated.array().square()).sum() + (kept_damping_.array() * kept.array().square()).sum();
  step.predicted_decrease = 0.5 * (damped_square + shifted_.squaredNorm() + kept_decrease);
  if constexpr (E == 6) {
    step.poses = std::move(eliminated);
    step.beams = std::move(kept_blocks);
  } else {
    step.poses = std::move(kept_blocks);
    step.beams = std::move(eliminated);
  }
  return step;
}

template <int E, int K>
Eigen::Matrix<double, E, Eigen::Dynamic> Elimination<E, K>::rows(int block) const {
  Eigen::Matrix<double, E, Eigen::Dynamic> result = Eigen::Matrix<double, E, Eigen::Dynamic>::Zero(E, columns_);
  for (std::size_t p = 0; p < panels_.size(); ++p) {
    const Panel& panel = panels_[p];
    const auto found = std::ranges::lower_bound(panel.blocks, block);
    if (found == panel.blocks.end() || *found != block) continue;
    const double* first = panel.rows.data() + (found - panel.blocks.begin()) * E * kTile;
    const Eigen::Map<const Eigen::Matrix<double, E, kTile, Eigen::RowMajor>> rows(first);
    const auto column = static_cast<Eigen::Index>(p) * kTile;
    const Eigen::Index count = std::min<Eigen::Index>(kTile, columns_ - column);
    result.middleCols(column, count) = rows.leftCols(count);
  }
  return result;
}

template class Elimination<6, 4>;
template class Elimination<4, 6>;

}  // namespace raybundle
