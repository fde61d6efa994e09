// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "raybundle/occupancy/embedding.hpp"

namespace raybundle {

inline constexpr int kEmbeddingBatch = 256;  ///< cases of a step

struct EmbeddingSearch {
  std::vector<int> sizes;  ///< of the layers, the last one that of the space
  int steps = 0;
  double decay = 0.0;    ///< how much weights are drawn to zero
  double dropout = 0.0;  ///< share of the values between layers that a step leaves out
  std::uint64_t seed = 1;
};

/// Looks for an embedding in which near cases are of one kind: maximises the sum over cases of the logarithm of the
/// share that their own kind has of their neighbourhood, neighbours counting exp(-squared distance), by stochastic
/// gradients. The same arguments give the same bits.
///
/// @param attributes  D×N
/// @param kinds       N
/// Source: Salakhutdinov, Hinton 2007 (nonlinear neighbourhood components analysis), without their pretraining; steps
/// by Adam (Kingma, Ba 2015), dropout by Srivastava et al. 2014
Embedding embedding_search(const Eigen::MatrixXf& attributes, const std::vector<int>& kinds,
                           const EmbeddingSearch& search);

}  // namespace raybundle
