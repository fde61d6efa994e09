// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "per_corner.hpp"

#include <ceres/autodiff_cost_function.h>
#include <ceres/ceres.h>
#include <ceres/manifold.h>

#include <array>

namespace raybundle::limit {
namespace {

struct Corner {
  Eigen::Vector3d x_in_target;
  Observation observation;

  template <typename T>
  bool operator()(const T* intrinsics, const T* pose, T* residual) const {
    const Eigen::Map<const Eigen::Quaternion<T>> turn(pose);
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> shift(pose + 4);
    const Eigen::Matrix<T, 3, 1> ray = turn * x_in_target.cast<T>() + shift;
    if (!pixel_from_ray<KannalaBrandt, T>(intrinsics, ray.data(), residual)) return false;
    for (int axis = 0; axis < 2; ++axis) {
      residual[axis] = (residual[axis] - observation.pixel[axis]) / observation.sigma_px;
    }
    return true;
  }
};

}  // namespace

BundleSummary solve_per_corner(const CalibrationProblem& problem, BundleState state) {
  using Pose = std::array<double, 7>;
  std::vector<Pose> poses(state.poses.size());
  ceres::ProductManifold<ceres::EigenQuaternionManifold, ceres::EuclideanManifold<3>> manifold;
  ceres::Problem::Options problem_options;
  problem_options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem ceres_problem(problem_options);
  ceres::Solver::Options options;
  options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  double* intrinsics = state.cameras[0].parameters.data();
  options.linear_solver_ordering->AddElementToGroup(intrinsics, 1);
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    const Rigid3& start = state.poses[state.pose_of_view[v]].rig_from_target;
    Pose& pose = poses[state.pose_of_view[v]];
    Eigen::Map<Eigen::Vector4d>(pose.data()) = start.rotation.coeffs();
    Eigen::Map<Eigen::Vector3d>(pose.data() + 4) = start.translation;
    for (const Observation& observation : problem.views[v].observations) {
      const TargetPoint* point = problem.targets[0].find(observation.point_id);
      auto* cost = new ceres::AutoDiffCostFunction<Corner, 2, 8, 7>(new Corner{point->x_in_target, observation});
      ceres_problem.AddResidualBlock(cost, nullptr, intrinsics, pose.data());
    }
    ceres_problem.SetManifold(pose.data(), &manifold);
    options.linear_solver_ordering->AddElementToGroup(pose.data(), 0);
  }
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = 100;
  options.function_tolerance = options.gradient_tolerance = 1e-14;  // solve_bundle may end before
  options.parameter_tolerance = 1e-12;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &ceres_problem, &summary);
  return {.termination = Termination::kConverged,
          .iterations = summary.num_successful_steps + summary.num_unsuccessful_steps,
          .initial_cost = summary.initial_cost,
          .final_cost = summary.final_cost,
          .message = summary.message};
}

}  // namespace raybundle::limit
