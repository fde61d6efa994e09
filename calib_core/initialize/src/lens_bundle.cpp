// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "lens_bundle.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "raybundle/geometry/target_clones.hpp"

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
                 double scale2) {
  const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
  double cost = 0.0;
  Eigen::Vector2d pixel;
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    const Eigen::Vector3d x = rotation * view.points[i] + pose.translation;
    if (!lens.project(parameters, x, pixel)) {
      cost += scale2;
      continue;
    }
    const double squared = (pixel - view.pixels[i]).squaredNorm();
    cost += std::isfinite(squared) ? scale2 * (squared / (scale2 + squared)) : scale2;
  }
  return cost;
}

// Of the cost: an iteration that lowers it by less is the last one; one that promises less is not tried.
constexpr double kLastDecrease = 1e-5, kNoDecrease = 1e-6;

constexpr int kLanes = 4;
constexpr int kMaxColumns = (kMaxLensParameters + 7 + kLanes - 1) / kLanes * kLanes;

// Adds a corner's two weighted products to sums of `stride` numbers in a row; only the upper triangle is meant.
RAYBUNDLE_TARGET_CLONES
void add_products(int columns, int stride, double weight, const double* __restrict u, const double* __restrict v,
                  double* __restrict sums) {
  for (int a = 0; a < columns; ++a) {
    const double weighted_u = weight * u[a];
    const double weighted_v = weight * v[a];
    double* row = sums + a * stride;
    for (int b = a / kLanes * kLanes; b < stride; b += kLanes) {
      for (int lane = 0; lane < kLanes; ++lane) row[b + lane] += weighted_u * u[b + lane] + weighted_v * v[b + lane];
    }
  }
}

/// Sums JᵀJ of rows [lens | pose | error]; plain arrays, because nothing here is large.
class RowSums {
 public:
  explicit RowSums(int columns) : columns_(columns), stride_((columns + kLanes - 1) / kLanes * kLanes) {
    std::fill_n(sums_, columns_ * stride_, 0.0);
  }

  /// @param u  kMaxColumns numbers, zero beyond the columns
  void add(double weight, const double* u, const double* v) { add_products(columns_, stride_, weight, u, v, sums_); }

  double operator()(int a, int b) const { return sums_[std::min(a, b) * stride_ + std::max(a, b)]; }

 private:
  int columns_;
  int stride_;
  double sums_[kMaxColumns * kMaxColumns];
};

void view_equations(const LensFunctions& lens, const double* parameters, const PointsInView& view, const Rigid3& pose,
                    double scale2, const LensBundleOptions& options, ViewEquations& equations) {
  const int n = lens.parameters;
  const int of_lens = options.lens_fixed ? 0 : n;
  const int of_pose = options.poses_fixed ? 0 : 6;
  const int error_column = of_lens + of_pose;
  RowSums sums(error_column + 1);
  const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> wrt_ray;
  double wrt_parameters[2 * kMaxLensParameters];
  double rows[2][kMaxColumns] = {};
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    const Eigen::Vector3d arm = rotation * view.points[i];
    if (!lens.project_with_jacobians(parameters, arm + pose.translation, pixel, wrt_ray, wrt_parameters)) continue;
    const Eigen::Vector2d error = pixel - view.pixels[i];
    const double damping = scale2 / (scale2 + error.squaredNorm());
    const double weight = damping * damping;
    if (!(weight > 1e-12)) continue;
    for (int axis = 0; axis < 2; ++axis) {
      double* row = rows[axis];
      std::copy_n(wrt_parameters + axis * n, of_lens, row);
      if (of_pose > 0) {
        const double* slope = wrt_ray.data() + 3 * axis;  // by the rotation: arm × slope
        double* turn = row + of_lens;
        turn[0] = arm[1] * slope[2] - arm[2] * slope[1];
        turn[1] = arm[2] * slope[0] - arm[0] * slope[2];
        turn[2] = arm[0] * slope[1] - arm[1] * slope[0];
        std::copy_n(slope, 3, turn + 3);
      }
      row[error_column] = error[axis];
    }
    sums.add(weight, rows[0], rows[1]);
  }
  equations.lens.setZero(n, n);
  equations.lens_right.setZero(n);
  equations.cross.setZero(n, 6);
  for (int a = 0; a < of_lens; ++a) {
    for (int b = 0; b < of_lens; ++b) equations.lens(a, b) = sums(a, b);
    for (int b = 0; b < of_pose; ++b) equations.cross(a, b) = sums(a, of_lens + b);
    equations.lens_right[a] = -sums(a, error_column);
  }
  equations.pose.setZero();
  equations.pose_right.setZero();
  for (int a = 0; a < of_pose; ++a) {
    for (int b = 0; b < of_pose; ++b) equations.pose(a, b) = sums(of_lens + a, of_lens + b);
    equations.pose_right[a] = -sums(of_lens + a, error_column);
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

LensFunctions lens_functions(ModelId model) {
  return with_model(model, []<CameraModel M>() { return lens_functions<M>(); });
}

LensBundleSummary refine_lens(const LensFunctions& lens, const std::vector<PointsInView>& views,
                              const LensBundleOptions& options, LensVector& parameters, std::vector<Rigid3>& poses) {
  const double scale2 = options.scale_px * options.scale_px;
  const auto total_cost = [&](const LensVector& p, const std::vector<Rigid3>& at) {
    if (!(p[0] > 0) || !(p[1] > 0)) return std::numeric_limits<double>::infinity();
    double cost = prior_cost(options, p);
    for (std::size_t v = 0; v < views.size(); ++v) cost += view_cost(lens, p.data(), views[v], at[v], scale2);
    return cost;
  };

  LensBundleSummary summary;
  summary.cost = total_cost(parameters, poses);
  std::vector<ViewEquations> equations(views.size());
  const auto linearise = [&] {
    for (std::size_t v = 0; v < views.size(); ++v) {
      view_equations(lens, parameters.data(), views[v], poses[v], scale2, options, equations[v]);
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
  distances_px.resize(view.points.size());
  const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
  Eigen::Vector2d pixel;
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    distances_px[i] = std::numeric_limits<double>::infinity();
    if (!lens.project(parameters, rotation * view.points[i] + pose.translation, pixel)) continue;
    const double distance = (pixel - view.pixels[i]).norm();
    if (std::isfinite(distance)) distances_px[i] = distance;
  }
}

}  // namespace raybundle
