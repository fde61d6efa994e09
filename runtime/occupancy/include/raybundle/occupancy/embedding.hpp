// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <string>
#include <vector>

namespace raybundle {

inline constexpr int kMostUnits = 256;  ///< values that a layer takes or gives
inline constexpr int kMostLayers = 8;

/// Values in, weights times values plus offsets out.
struct EmbeddingLayer {
  Eigen::MatrixXf weights;  ///< out × in
  Eigen::VectorXf offsets;  ///< out
};

/// A place in the space of an embedding; the first size() values count.
using EmbeddedPlace = std::array<float, kMostUnits>;

/// Takes the attributes of a situation to a place whose neighbours are situations of the same kind: attributes in
/// units of their scatter, then layers, with what is negative cut to zero between them. At least one layer.
struct Embedding {
  Eigen::VectorXf centre;  ///< of the learnt attributes
  Eigen::VectorXf scale;   ///< one over their standard deviations
  std::vector<EmbeddingLayer> layers;

  Eigen::Index attributes() const { return centre.size(); }
  Eigen::Index size() const { return layers.back().weights.rows(); }

  /// Without heap; the same bits on every run.
  EmbeddedPlace place(const Eigen::Ref<const Eigen::VectorXd>& of_attributes) const;

  /// @param where  name of its file, for messages
  /// @throws Error(kBadInput) when sizes do not agree or a number is not finite
  void check(const std::string& where = {}) const;
};

}  // namespace raybundle
