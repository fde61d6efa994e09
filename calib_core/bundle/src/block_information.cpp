// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "block_information.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <limits>

#include "elimination.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

constexpr double kUnseen = 1e-12;  // of the largest eigenvalue: for beams, dots within some micrometres of each other

// Adds to a block's information what makes it definite; returns the number of directions that needed it.
template <int N>
int pin(const Eigen::Matrix<double, N, 1>& scale, Eigen::Ref<Eigen::Matrix<double, N, N>> own) {
  const Eigen::Matrix<double, N, N> scaled =
      scale.cwiseInverse().asDiagonal() * own * scale.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, N, N>> axes(scaled);
  const double largest = std::max(axes.eigenvalues()[N - 1], std::numeric_limits<double>::min());
  const double information = axes.eigenvalues()[N - 1] > 0.0 ? largest : 1.0;
  int pinned = 0;
  for (int k = 0; k < N && (axes.eigenvalues()[k] <= kUnseen * largest); ++k, ++pinned) {
    const Eigen::Matrix<double, N, 1> direction = scale.asDiagonal() * axes.eigenvectors().col(k);
    own += information * direction * direction.transpose();
  }
  return pinned;
}

template <typename Function>
void with_cheaper_elimination(const BlockSystem& system, const Function& function) {
  if (Elimination<4, 6>::cost(system) < Elimination<6, 4>::cost(system)) {
    Elimination<4, 6> elimination(system);
    function(elimination);
  } else {
    Elimination<6, 4> elimination(system);
    function(elimination);
  }
}

// Reduces and factors the complement of the first kept unknowns. What the residuals do not see may make it singular;
// then the diagonal is raised by as little as helps, and what is not seen comes out as unknown to that degree.
template <int E, int K>
void factor_first(Elimination<E, K>& elimination, const BlockSystem& system, int count, Workers& workers) {
  for (const double radius : {std::numeric_limits<double>::infinity(), 1e14, 1e12, 1e10, 1e8}) {
    if (elimination.reduce(system, radius, workers) && elimination.factor(count, workers)) return;
  }
  throw Error(ErrorKind::kSolveFailed, "the normal equations of poses and beams are not positive definite");
}

}  // namespace

PinnedDirections pin_unseen(BlockSystem& system) {
  PinnedDirections pinned;
  for (int p = 0; p < system.poses.blocks(); ++p) {
    Eigen::Matrix<double, 6, 6> own = system.poses.own.middleCols<6>(6 * p);
    pinned.of_poses += pin<6>(own.diagonal().unaryExpr([](double d) { return d > 0.0 ? std::sqrt(d) : 1.0; }), own);
    system.poses.own.middleCols<6>(6 * p) = own;
  }
  BlockFamily<4>& beams = system.shared.beams;
  for (int b = 0; b < beams.blocks(); ++b) {
    Eigen::Matrix4d own = beams.own.middleCols<4>(4 * b);
    pinned.of_beam.push_back(pin<4>(Eigen::Vector4d::Ones(), own));
    beams.own.middleCols<4>(4 * b) = own;
  }
  return pinned;
}

Eigen::MatrixXd parameter_information(const BlockSystem& system, Workers& workers) {
  Eigen::MatrixXd information;
  with_cheaper_elimination(system, [&](auto& elimination) {
    const int blocks = elimination.first_parameter();
    const int parameters = system.parameters();
    factor_first(elimination, system, blocks, workers);
    const Eigen::MatrixXd& complement = elimination.complement();
    information = complement.block(blocks, blocks, parameters, parameters).template selfadjointView<Eigen::Upper>();
  });
  return information;
}

std::vector<BeamCovariance> marginal_beams(const BlockSystem& system, Workers& workers) {
  const int beams = system.shared.beams.blocks();
  const int parameters = system.parameters();
  std::vector<BeamCovariance> covariances(beams);
  with_cheaper_elimination(system, [&]<int E, int K>(Elimination<E, K>& elimination) {
    const int kept = elimination.kept();
    factor_first(elimination, system, kept, workers);
    const auto upper = elimination.complement().topLeftCorner(kept, kept).template triangularView<Eigen::Upper>();
    // U⁻ᵀ times the unit vectors of the parameters; only their own rows are not zero.
    Eigen::MatrixXd of_parameters = Eigen::MatrixXd::Identity(parameters, parameters);
    elimination.complement()
        .block(elimination.first_parameter(), elimination.first_parameter(), parameters, parameters)
        .template triangularView<Eigen::Upper>()
        .transpose()
        .solveInPlace(of_parameters);
    workers.for_each(beams, [&](int b) {
      BeamCovariance& covariance = covariances[b];
      Eigen::MatrixXd half = Eigen::MatrixXd::Zero(kept, 4);
      Eigen::Matrix4d own = Eigen::Matrix4d::Zero();
      if constexpr (E == 4) {
        const auto lower = elimination.block_factor(b).template triangularView<Eigen::Lower>();
        const Eigen::Matrix4d inverse = lower.solve(Eigen::Matrix4d::Identity());
        own = inverse.transpose() * inverse;
        half = -(inverse.transpose() * elimination.rows(b)).transpose();
      } else {
        half.middleRows<4>(4 * b).setIdentity();
      }
      upper.transpose().solveInPlace(half);
      const Eigen::Matrix4d sum = own + half.transpose() * half;
      covariance.of_beam = sum.selfadjointView<Eigen::Upper>();  // to the last bit, however products are summed
      covariance.with_parameters = half.bottomRows(parameters).transpose() * of_parameters;
    });
  });
  return covariances;
}

}  // namespace raybundle
