// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "block_system.hpp"
#include "raybundle/bundle/information.hpp"
#include "workers.hpp"

namespace raybundle {

/// How many directions no residual sees.
struct PinnedDirections {
  int of_poses = 0;          ///< of all poses together
  std::vector<int> of_beam;  ///< of each beam that takes part
};

/// Gives every direction of a pose or a beam that no residual of its own sees, such as the slopes of a beam with one
/// dot, an information of its own. These directions have nothing in common with any other unknown, so that nothing
/// else changes, but the equations can be factored without damping.
PinnedDirections pin_unseen(BlockSystem& system);

/// What the equations say of the parameters when poses and beams may follow freely. Both triangles.
Eigen::MatrixXd parameter_information(const BlockSystem& system, Workers& workers);

/// Marginal covariance of each beam.
std::vector<BeamCovariance> marginal_beams(const BlockSystem& system, Workers& workers);

}  // namespace raybundle
