// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Processor time of one bundle adjustment in three forms: compressed views, whole views, and what one writes first with
// Ceres, one automatically differentiated residual for each corner. Same start, same solver, same tolerances, one
// thread. usage: bench_bundle [views] [repetitions]
#include <ceres/autodiff_cost_function.h>
#include <ceres/ceres.h>
#include <ceres/manifold.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>

#include "raybundle/bundle/bundle.hpp"
#include "synthetic_world.hpp"

namespace {

using namespace raybundle;

// Other work on the machine must not count: processor time of this process.
double seconds_now() {
  timespec time;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

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

struct Outcome {
  double cost = 0.0;
  int iterations = 0;
};

Outcome solve_per_corner(const CalibrationProblem& problem, BundleState state) {
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
  options.function_tolerance = options.gradient_tolerance = 1e-14;  // as solve_bundle
  options.parameter_tolerance = 1e-12;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &ceres_problem, &summary);
  return {summary.final_cost, summary.num_successful_steps + summary.num_unsuccessful_steps};
}

Outcome solve_views(const CalibrationProblem& problem, BundleState state, bool compressed) {
  const BundleSummary summary = solve_bundle(problem, state, {.compressed_views = compressed});
  return {summary.final_cost, summary.iterations};
}

// 14 x 10 corners through a fisheye camera, the start some percent and degrees away.
void make_problem(int views, CalibrationProblem& problem, BundleState& start) {
  testing::SyntheticOptions options;
  options.columns = 14;
  options.rows = 10;
  options.square_m = 0.025;
  options.frames = views;
  options.noise_px = 0.1;
  const testing::SyntheticWorld world = testing::synthetic_world(options);
  problem = world.problem;
  start = {world.cameras, world.camera_from_rig, world.poses, world.shapes, world.pose_of_view, {}};
  start.cameras[0].parameters.head<2>() *= 1.05;
  start.cameras[0].parameters.tail<4>().setZero();
  Eigen::Matrix<double, 6, 1> motion;
  motion << 0.02, -0.01, 0.01, 0.01, 0.005, 0.02;
  for (BoardPose& pose : start.poses) pose.rig_from_target = perturbed(pose.rig_from_target, motion);
  mark_projectable(problem, start);
}

// Best of the repetitions: the one that was disturbed the least.
double measure(const char* name, int repetitions, double fastest_ms, const std::function<Outcome()>& solve) {
  double best_ms = 1e300;
  Outcome outcome;
  for (int i = 0; i < repetitions; ++i) {
    const double begin = seconds_now();
    outcome = solve();
    best_ms = std::min(best_ms, 1e3 * (seconds_now() - begin));
  }
  std::printf("%-34s %9.2f ms %6.1fx  %3d iterations  cost %.9g\n", name, best_ms,
              best_ms / (fastest_ms > 0 ? fastest_ms : best_ms), outcome.iterations, outcome.cost);
  return best_ms;
}

}  // namespace

int main(int argc, char** argv) {
  const int views = argc > 1 ? std::atoi(argv[1]) : 200;
  const int repetitions = argc > 2 ? std::atoi(argv[2]) : 10;
  CalibrationProblem problem;
  BundleState start;
  make_problem(views, problem, start);
  std::size_t corners = 0;
  for (const TargetView& view : problem.views) corners += view.observations.size();
  std::printf("%zu views, %zu corners, kannala_brandt, one thread, processor time\n", problem.views.size(), corners);
  const double ours =
      measure("compressed views (solve_bundle)", repetitions, 0, [&] { return solve_views(problem, start, true); });
  measure("whole views", repetitions, ours, [&] { return solve_views(problem, start, false); });
  measure("Ceres, autodiff for each corner", repetitions, ours, [&] { return solve_per_corner(problem, start); });
  return 0;
}
