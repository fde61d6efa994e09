// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace raybundle {

/// Blocks of N unknowns each that do not meet each other in the normal equations.
template <int N>
struct BlockFamily {
  using Rows = Eigen::Matrix<double, N, Eigen::Dynamic>;
  Rows own;              ///< N columns for each block: its diagonal block, both triangles
  Rows with_parameters;  ///< one column for each parameter, block after block
  Rows gradient;         ///< one column for each block

  BlockFamily() = default;
  BlockFamily(int blocks, int parameters)
      : own(Rows::Zero(N, N * blocks)),
        with_parameters(Rows::Zero(N, static_cast<Eigen::Index>(parameters) * blocks)),
        gradient(Rows::Zero(N, blocks)) {}

  int blocks() const { return static_cast<int>(gradient.cols()); }

  void operator+=(const BlockFamily& other) {
    own += other.own;
    with_parameters += other.with_parameters;
    gradient += other.gradient;
  }
};

/// What a board pose and a beam that met it have in common in the normal equations: by_pose by_beamᵀ. A board moves a
/// dot along the beam only, so that the block has rank one, whatever the number of cameras that see the dot.
struct PoseBeamBlock {
  int pose = 0;
  int beam = 0;
  Eigen::Matrix<double, 6, 1> by_pose = Eigen::Matrix<double, 6, 1>::Zero();
  Eigen::Vector4d by_beam = Eigen::Vector4d::Zero();
};

/// The normal equations of a bundle with beams: of the parameters, of the poses and of the beams.
struct BlockSystem {
  /// What several poses add to.
  struct Shared {
    Eigen::MatrixXd matrix;    ///< of the parameters, upper triangle
    Eigen::VectorXd gradient;  ///< of the parameters
    BlockFamily<4> beams;

    Shared() = default;
    Shared(int parameters, int beam_count)
        : matrix(Eigen::MatrixXd::Zero(parameters, parameters)),
          gradient(Eigen::VectorXd::Zero(parameters)),
          beams(beam_count, parameters) {}

    void operator+=(const Shared& other) {
      matrix += other.matrix;
      gradient += other.gradient;
      beams += other.beams;
    }
  };

  BlockFamily<6> poses;
  Shared shared;
  std::vector<PoseBeamBlock> pose_beams;  ///< sorted by pose, then by beam; of each pair at most one
  double chi2 = 0.0;                      ///< sum of the squared residuals, weighted as the equations are

  int parameters() const { return static_cast<int>(shared.gradient.size()); }
};

/// A damped Gauss-Newton step of a BlockSystem.
struct BlockStep {
  Eigen::VectorXd parameters;
  Eigen::Matrix<double, 6, Eigen::Dynamic> poses;
  Eigen::Matrix<double, 4, Eigen::Dynamic> beams;
  double predicted_decrease = 0.0;  ///< of the cost, by the undamped quadratic model
};

/// Diagonal to be added; nothing may stay without any, not even what no observation depends on.
inline double damping(double diagonal, double radius) { return std::max(diagonal, 1e-6) / radius; }

}  // namespace raybundle
