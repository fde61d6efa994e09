// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "lens_bundle.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "raybundle/geometry/gram.hpp"

namespace raybundle {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Cross = Eigen::Matrix<double, Eigen::Dynamic, 6, 0, kMaxLensParameters, 6>;

/// Normal equations of one view: its pose and its share in the lens.
struct ViewEquations {
  LensMatrix lens;
  LensVector lens_right;
  Cross cross;
  Matrix6 pose;
  Vector6 pose_right;
};

double view_cost(const LensFunctions& lens, const double* parameters, const PointsInView& view, const Rigid3& pose,
                 double scale2, std::vector<double>& distances2) {
  lens.squared_distances(parameters, view, pose, distances2);
  double cost = 0.0;
  for (const double squared : distances2)
    cost += std::isfinite(squared) ? scale2 * (squared / (scale2 + squared)) : scale2;
  return cost;
}

// Of the cost: an iteration that lowers it by less is the last one; one that promises less is not tried.
constexpr double kLastDecrease = 1e-4, kNoDecrease = 1e-6;

void view_equations(const LensFunctions& lens, const double* parameters, const PointsInView& view, const Rigid3& pose,
                    const LensBundleOptions& options, ViewEquations& equations) {
  thread_local LensRows rows;
  thread_local Eigen::MatrixXd products;
  lens.linearise(parameters, view, pose, options.scale_px, rows);
  const int n = lens.parameters, error = n + 6;
  Eigen::Matrix<double, kMaxLensParameters + 7, kMaxLensParameters + 7> sums;
  sums.topLeftCorner(n + 7, n + 7).setZero();
  for (int axis = 0; axis < 2; ++axis) {
    gram(rows.of_axis[axis], products);
    for (int b = 0; b < products.cols(); ++b) {
      for (int a = 0; a <= b; ++a) sums(LensRows::index(axis, a), LensRows::index(axis, b)) += products(a, b);
    }
  }
  equations.lens.setZero(n, n);
  equations.lens_right.setZero(n);
  equations.cross.setZero(n, 6);
  equations.pose.setZero();
  equations.pose_right.setZero();
  if (!options.lens_fixed) {
    equations.lens = sums.topLeftCorner(n, n).selfadjointView<Eigen::Upper>();
    equations.lens_right = -sums.col(error).head(n);
  }
  if (!options.poses_fixed) {
    equations.pose = sums.block<6, 6>(n, n).selfadjointView<Eigen::Upper>();
    equations.pose_right = -sums.col(error).segment<6>(n);
  }
  if (!options.lens_fixed && !options.poses_fixed) equations.cross = sums.block(0, n, n, 6);
}

double prior_cost(const LensBundleOptions& options, const LensVector& parameters) {
  double cost = 0.0;
  if (options.prior_mean.size() > 0) {
    cost += (parameters - options.prior_mean).cwiseProduct(options.prior_weight).squaredNorm();
  }
  const double skewed = options.aspect_weight * (parameters[1] / parameters[0] - 1.0);
  return cost + skewed * skewed;
}

void add_priors(const LensBundleOptions& options, const LensVector& parameters, LensMatrix& normal, LensVector& right) {
  if (options.prior_mean.size() > 0) {
    const LensVector weight2 = options.prior_weight.cwiseAbs2();
    normal.diagonal() += weight2;
    right -= weight2.cwiseProduct(parameters - options.prior_mean);
  }
  const double weight2 = options.aspect_weight * options.aspect_weight;
  const double ratio = parameters[1] / parameters[0];
  const Eigen::Vector2d slope(-ratio / parameters[0], 1.0 / parameters[0]);
  normal.topLeftCorner<2, 2>() += weight2 * slope * slope.transpose();
  right.head<2>() -= weight2 * slope * (ratio - 1.0);
}

/// Marquardt's damping; the floor keeps directions that nothing sees from running away.
template <typename Matrix>
void damp(Matrix& matrix, double lambda) {
  const double floor = 1e-12 * std::max(matrix.diagonal().maxCoeff(), 1e-12);
  matrix.diagonal().array() += lambda * matrix.diagonal().array() + floor;
}

/// Leaves no step to parameters that keep their value.
void hold(const std::vector<int>& held, LensMatrix& normal, LensVector& right) {
  for (const int i : held) {
    normal.row(i).setZero();
    normal.col(i).setZero();
    normal(i, i) = 1.0;
    right[i] = 0.0;
  }
}

struct Step {
  LensVector lens;
  std::vector<Vector6> poses;
  double decrease = 0.0;  ///< of the cost, that the equations promise
};

/// Back substitution: the poses' steps for the lens's.
bool solve_poses(const std::vector<ViewEquations>& equations, const std::vector<Eigen::LLT<Matrix6>>& factors,
                 Step& step) {
  step.poses.assign(equations.size(), Vector6::Zero());
  for (std::size_t v = 0; v < factors.size(); ++v) {
    step.poses[v] = factors[v].solve(equations[v].pose_right - equations[v].cross.transpose() * step.lens);
    if (!step.poses[v].allFinite()) return false;
    step.decrease += equations[v].pose_right.dot(step.poses[v]);
  }
  return true;
}

/// One damped step.
bool solve_step(const std::vector<ViewEquations>& equations, const LensBundleOptions& options,
                const LensVector& parameters, double lambda, Step& step) {
  const Eigen::Index n = parameters.size();
  LensMatrix normal = LensMatrix::Zero(n, n);
  LensVector right = LensVector::Zero(n);
  for (const ViewEquations& view : equations) {
    normal += view.lens;
    right += view.lens_right;
  }
  add_priors(options, parameters, normal, right);
  const LensVector right_of_lens = right;
  damp(normal, lambda);
  std::vector<Eigen::LLT<Matrix6>> factors;
  if (!options.poses_fixed) {
    factors.reserve(equations.size());
    for (const ViewEquations& view : equations) {
      Matrix6 pose = view.pose;
      damp(pose, lambda);
      factors.emplace_back(pose);
      if (options.lens_fixed) continue;
      const Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, kMaxLensParameters> solved =
          factors.back().solve(view.cross.transpose());
      normal.noalias() -= view.cross.lazyProduct(solved);
      right.noalias() -= solved.transpose().lazyProduct(view.pose_right);
    }
  }
  if (options.lens_fixed) {
    step.lens.setZero(n);
    step.decrease = 0.0;
    return solve_poses(equations, factors, step);
  }
  hold(options.held, normal, right);
  const LensVector scale = normal.diagonal().cwiseMax(1e-30).cwiseSqrt().cwiseInverse();
  const LensMatrix scaled = scale.asDiagonal() * normal * scale.asDiagonal();
  step.lens = scale.cwiseProduct(LensVector(scaled.ldlt().solve(scale.cwiseProduct(right))));
  if (!step.lens.allFinite()) return false;
  step.decrease = right_of_lens.dot(step.lens);
  return solve_poses(equations, factors, step);
}

LensMatrix reduced_information(const std::vector<ViewEquations>& equations, int n, bool poses_fixed) {
  LensMatrix information = LensMatrix::Zero(n, n);
  for (const ViewEquations& view : equations) {
    information += view.lens;
    if (poses_fixed) continue;
    Matrix6 pose = view.pose;
    damp(pose, 1e-12);
    const Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, kMaxLensParameters> solved =
        pose.llt().solve(view.cross.transpose());
    information.noalias() -= view.cross.lazyProduct(solved);
  }
  return information;
}

}  // namespace

LensBundleSummary refine_lens(const LensFunctions& lens, const std::vector<PointsInView>& views,
                              const LensBundleOptions& options, LensVector& parameters, std::vector<Rigid3>& poses) {
  const double scale2 = options.scale_px * options.scale_px;
  std::vector<double> distances2;
  const auto total_cost = [&](const LensVector& p, const std::vector<Rigid3>& at) {
    if (!(p[0] > 0) || !(p[1] > 0)) return std::numeric_limits<double>::infinity();
    double cost = prior_cost(options, p);
    for (std::size_t v = 0; v < views.size(); ++v)
      cost += view_cost(lens, p.data(), views[v], at[v], scale2, distances2);
    return cost;
  };

  LensBundleSummary summary;
  summary.cost = total_cost(parameters, poses);
  std::vector<ViewEquations> equations(views.size());
  const auto linearise = [&] {
    for (std::size_t v = 0; v < views.size(); ++v) {
      view_equations(lens, parameters.data(), views[v], poses[v], options, equations[v]);
    }
  };
  double lambda = 1e-4;
  Step step;
  for (; summary.iterations < options.max_iterations; ++summary.iterations) {
    linearise();
    bool improved = false;
    bool converged = false;
    while (!improved && lambda < 1e10) {
      if (solve_step(equations, options, parameters, lambda, step)) {
        if (std::abs(step.decrease) < kNoDecrease * summary.cost) break;
        const LensVector moved = parameters + step.lens;
        std::vector<Rigid3> moved_poses = poses;
        if (!options.poses_fixed) {
          for (std::size_t v = 0; v < poses.size(); ++v) moved_poses[v] = perturbed(poses[v], step.poses[v]);
        }
        const double cost = total_cost(moved, moved_poses);
        if (cost < summary.cost) {
          converged = summary.cost - cost < kLastDecrease * summary.cost;
          summary.cost = cost;
          parameters = moved;
          poses = std::move(moved_poses);
          lambda = std::max(0.1 * lambda, 1e-10);
          improved = true;
          continue;
        }
      }
      lambda *= 10.0;
    }
    if (!improved || converged) break;
  }
  if (!options.with_information) return summary;
  linearise();
  summary.information = reduced_information(equations, lens.parameters, options.poses_fixed);
  return summary;
}

void pixel_distances(const LensFunctions& lens, const double* parameters, const PointsInView& view, const Rigid3& pose,
                     std::vector<double>& distances_px) {
  lens.squared_distances(parameters, view, pose, distances_px);
  for (double& distance : distances_px) distance = std::sqrt(distance);
}

}  // namespace raybundle
