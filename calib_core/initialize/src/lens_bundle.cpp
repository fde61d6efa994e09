// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "lens_bundle.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "raybundle/geometry/gram.hpp"
#include "small_cholesky.hpp"

namespace raybundle {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;
/// Normal equations of one view: upper triangle of the products of lens, pose and error.
using ViewEquations =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxLensParameters + 7, kMaxLensParameters + 7>;

double view_cost(const LensFunctions& lens, const double* parameters, const PointsInView& view, const Rigid3& pose,
                 double scale2, std::vector<double>& distances2) {
  lens.squared_distances(parameters, view, pose, distances2);
  double cost = 0.0;
  for (const double squared : distances2)
    cost += std::isfinite(squared) ? scale2 * (squared / (scale2 + squared)) : scale2;
  return cost;
}

constexpr double kNoDecrease = 1e-2;  ///< of the last decrease: an iteration that promises less is not tried

void view_equations(const LensFunctions& lens, const double* parameters, const PointsInView& view, const Rigid3& pose,
                    const LensBundleOptions& options, ViewEquations& equations) {
  thread_local LensRows rows;
  thread_local Eigen::MatrixXd products;
  lens.linearise(parameters, view, pose, options.scale_px, rows);
  equations.setZero(lens.parameters + 7, lens.parameters + 7);
  for (int axis = 0; axis < 2; ++axis) {
    gram(rows.of_axis[axis], products);
    for (int b = 0; b < products.cols(); ++b) {
      for (int a = 0; a <= b; ++a) equations(LensRows::index(axis, a), LensRows::index(axis, b)) += products(a, b);
    }
  }
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

/// Poses eliminated: of each view's pose the Cholesky factor L, and L⁻¹ times its rows of the equations.
struct Elimination {
  std::vector<SmallCholesky<6>> factors;
  Eigen::MatrixXd rows;      ///< six for each view, by the lens and the right side, up to a multiple of four
  Eigen::MatrixXd products;  ///< upper triangle of rowsᵀ rows: what the lens loses
};

/// @param n  parameters of the lens; 0 where it is fixed
bool eliminate_poses(const std::vector<ViewEquations>& equations, int n, double lambda, Elimination& eliminated) {
  const auto used = static_cast<Eigen::Index>(6 * equations.size());
  eliminated.factors.clear();
  eliminated.rows.resize(padded_for_gram(used), n + 1);
  eliminated.rows.bottomRows(eliminated.rows.rows() - used).setZero();
  Eigen::Index row = 0;
  for (const ViewEquations& view : equations) {
    const Eigen::Index error = view.cols() - 1, first = error - 6;
    Matrix6 pose = view.block<6, 6>(first, first).transpose();
    damp(pose, lambda);
    const SmallCholesky<6>& factor = eliminated.factors.emplace_back(pose);
    if (!factor.positive()) return false;
    for (int k = 0; k < n; ++k) {
      eliminated.rows.block<6, 1>(row, k) = factor.half_solved(view.block<1, 6>(k, first).transpose());
    }
    eliminated.rows.block<6, 1>(row, n) = factor.half_solved(-view.block<6, 1>(first, error));
    row += 6;
  }
  if (n > 0) gram(eliminated.rows, eliminated.products);
  return true;
}

struct Step {
  LensVector lens;
  std::vector<Vector6> poses;
  double decrease = 0.0;  ///< of the cost, that the equations promise
};

/// Back substitution: the poses' steps for the lens's.
bool solve_poses(const std::vector<ViewEquations>& equations, const Elimination& eliminated, bool lens_fixed,
                 Step& step) {
  Eigen::Index row = 0;
  for (std::size_t v = 0; v < step.poses.size(); ++v, row += 6) {
    const auto rows = eliminated.rows.middleRows<6>(row);
    const Eigen::Index error = equations[v].cols() - 1;
    Vector6 half = rows.rightCols<1>();
    if (!lens_fixed) half -= rows.leftCols(step.lens.size()).lazyProduct(step.lens);
    step.poses[v] = eliminated.factors[v].solved(half);
    if (!step.poses[v].allFinite()) return false;
    step.decrease -= equations[v].col(error).segment<6>(error - 6).dot(step.poses[v]);
  }
  return true;
}

/// Equations of the lens alone, both triangles.
void add_lens(const std::vector<ViewEquations>& equations, LensMatrix& normal, LensVector& right) {
  const Eigen::Index n = right.size();
  for (const ViewEquations& view : equations) {
    for (Eigen::Index b = 0; b < n; ++b) {
      for (Eigen::Index a = 0; a <= b; ++a) normal(a, b) += view(a, b);
      right[b] -= view(b, n + 6);
    }
  }
  normal.triangularView<Eigen::StrictlyLower>() = normal.transpose();
}

/// One damped step.
bool solve_step(const std::vector<ViewEquations>& equations, const LensBundleOptions& options,
                const LensVector& parameters, double lambda, Elimination& eliminated, Step& step) {
  const Eigen::Index n = parameters.size();
  step.poses.assign(equations.size(), Vector6::Zero());
  const int seen = options.lens_fixed ? 0 : static_cast<int>(n);
  if (!options.poses_fixed && !eliminate_poses(equations, seen, lambda, eliminated)) return false;
  step.lens.setZero(n);
  step.decrease = 0.0;
  if (options.lens_fixed) return options.poses_fixed || solve_poses(equations, eliminated, true, step);
  LensMatrix normal = LensMatrix::Zero(n, n);
  LensVector right = LensVector::Zero(n);
  add_lens(equations, normal, right);
  add_priors(options, parameters, normal, right);
  const LensVector right_of_lens = right;
  damp(normal, lambda);
  if (!options.poses_fixed) {
    normal -= LensMatrix(eliminated.products.topLeftCorner(n, n).selfadjointView<Eigen::Upper>());
    right -= eliminated.products.col(n).head(n);
  }
  hold(options.held, normal, right);
  const LensVector scale = normal.diagonal().cwiseMax(1e-30).cwiseSqrt().cwiseInverse();
  const LensMatrix scaled = scale.asDiagonal() * normal * scale.asDiagonal();
  step.lens = scale.cwiseProduct(LensVector(scaled.ldlt().solve(scale.cwiseProduct(right))));
  if (!step.lens.allFinite()) return false;
  step.decrease = right_of_lens.dot(step.lens);
  return options.poses_fixed || solve_poses(equations, eliminated, false, step);
}

LensMatrix reduced_information(const std::vector<ViewEquations>& equations, int n, bool poses_fixed) {
  LensMatrix information = LensMatrix::Zero(n, n);
  LensVector right = LensVector::Zero(n);
  add_lens(equations, information, right);
  if (poses_fixed) return information;
  Elimination eliminated;
  if (!eliminate_poses(equations, n, 1e-12, eliminated)) return LensMatrix::Zero(n, n);  // nothing can be told
  return information - LensMatrix(eliminated.products.topLeftCorner(n, n).selfadjointView<Eigen::Upper>());
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
  Elimination eliminated;
  for (; summary.iterations < options.max_iterations; ++summary.iterations) {
    linearise();
    bool improved = false;
    bool converged = false;
    while (!improved && lambda < 1e10) {
      if (solve_step(equations, options, parameters, lambda, eliminated, step)) {
        if (std::abs(step.decrease) < kNoDecrease * options.last_decrease * summary.cost) break;
        const LensVector moved = parameters + step.lens;
        std::vector<Rigid3> moved_poses = poses;
        if (!options.poses_fixed) {
          for (std::size_t v = 0; v < poses.size(); ++v) moved_poses[v] = perturbed(poses[v], step.poses[v]);
        }
        const double cost = total_cost(moved, moved_poses);
        if (cost < summary.cost) {
          converged = summary.cost - cost < options.last_decrease * summary.cost;
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
