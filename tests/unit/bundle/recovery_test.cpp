// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <random>

#include "bundle_worlds.hpp"
#include "raybundle/bundle/bundle.hpp"
#include "raybundle/bundle/view_block.hpp"

namespace raybundle::testing {
namespace {

// Exact observations: the truth comes back from a disturbed start.
void expect_truth(const SyntheticOptions& world_options, const BundleOptions& options = {}) {
  const SyntheticWorld world = synthetic_world(world_options);
  const BundleState truth = true_state(world);
  BundleState state = disturbed(truth);
  mark_projectable(world.problem, state);
  const BundleSummary summary = solve_bundle(world.problem, state, options);
  EXPECT_EQ(summary.termination, Termination::kConverged) << summary.message;
  EXPECT_LE(largest_difference(state, truth), 1e-8) << summary.message;
  EXPECT_GT(summary.initial_cost, 1.0);
  EXPECT_LT(summary.final_cost, 1e-12);
}

class RecoverEveryModel : public ::testing::TestWithParam<std::string_view> {};
TEST_P(RecoverEveryModel, OneCamera) {
  SyntheticOptions options;
  options.cameras[0].model = std::string(GetParam());
  options.max_off_axis_rad = 0.5;
  options.frames = 30;
  expect_truth(options);
}
INSTANTIATE_TEST_SUITE_P(Models, RecoverEveryModel, ::testing::ValuesIn(model_names()),
                         [](const auto& tested) { return std::string(tested.param); });

TEST(Recover, Stereo) { expect_truth(stereo_options()); }

TEST(Recover, RigInWhichOnlySomeCamerasSeeTheBoardAndModelsDiffer) {
  SyntheticOptions options;
  options.cameras = {SyntheticCamera{}, rig_camera("double_sphere", 1.2, -0.2), rig_camera("pinhole", 2.1, -0.4)};
  options.cameras[2].focal_px = 600;
  options.frames = 45;
  const SyntheticWorld world = synthetic_world(options);
  std::vector<int> cameras_of_frame(world.problem.frames.size(), 0);
  for (const TargetView& view : world.problem.views) ++cameras_of_frame[view.frame];
  ASSERT_GT(std::ranges::count(cameras_of_frame, 1), 0) << "some frames are to be seen by one camera only";
  ASSERT_GT(std::ranges::count(cameras_of_frame, 2), 5) << "some frames are to link two cameras";
  expect_truth(options);
}

TEST(Recover, SeveralBoards) {
  SyntheticOptions options = stereo_options();
  options.boards = 2;
  options.frames = 12;
  expect_truth(options);
}

TEST(Recover, BentBoard) {
  SyntheticOptions options = stereo_options();
  options.shape = {0.003, -0.002, 0.0015};
  expect_truth(options, {.estimate_shape = true});
}

// Bent but not estimated: the shape in the state counts all the same.
TEST(Recover, KnownShape) {
  SyntheticOptions options;
  options.shape = {0.003, -0.002, 0.0015};
  const SyntheticWorld world = synthetic_world(options);
  const BundleState truth = true_state(world);
  BundleState state = disturbed(truth);
  state.shapes = truth.shapes;
  solve_bundle(world.problem, state);
  EXPECT_LE(largest_difference(state, truth), 1e-8);
}

// Two corners cannot say where a board is, but must not keep the other views from their answer.
TEST(Recover, ViewWithFewCorners) {
  const SyntheticWorld world = synthetic_world({});
  const BundleState truth = true_state(world);
  BundleState state = disturbed(truth);
  for (std::size_t i = 2; i < state.fates[3].size(); ++i) state.fates[3][i] = ObservationFate::kOutlier;
  const BundleSummary summary = solve_bundle(world.problem, state);
  EXPECT_EQ(summary.termination, Termination::kConverged) << summary.message;
  EXPECT_LE((state.cameras[0].parameters - truth.cameras[0].parameters).cwiseAbs().maxCoeff(), 1e-6);
}

class NoisyStereo : public ::testing::Test {
 protected:
  NoisyStereo() {
    SyntheticOptions options = stereo_options();
    options.noise_px = 0.3;
    options.shape = {0.001, 0, 0};
    world_ = synthetic_world(options);
    start_ = disturbed(true_state(world_));
  }
  BundleState solved(const BundleOptions& options) const {
    BundleState state = start_;
    const BundleSummary summary = solve_bundle(world_.problem, state, options);
    EXPECT_NE(summary.termination, Termination::kFailed) << summary.message;
    return state;
  }
  SyntheticWorld world_;
  BundleState start_;
};

TEST_F(NoisyStereo, ThreadsDoNotChangeABit) {
  const BundleState one = solved({.estimate_shape = true, .robust_scale_sigma = 2, .threads = 1});
  for (const int threads : {2, 3, 7}) {
    const BundleState many = solved({.estimate_shape = true, .robust_scale_sigma = 2, .threads = threads});
    EXPECT_EQ(largest_difference(one, many), 0.0) << threads;
    for (std::size_t p = 0; p < one.poses.size(); ++p) {
      const Rigid3& a = one.poses[p].rig_from_target;
      const Rigid3& b = many.poses[p].rig_from_target;
      ASSERT_TRUE(a.rotation.coeffs() == b.rotation.coeffs() && a.translation == b.translation);
    }
  }
}

// The solver works on sums over a view's corners; linearize_view gives the corners' rows. At the answer the columns of
// every unknown are orthogonal to the residual that those rows spell out.
TEST_F(NoisyStereo, GradientOfEveryCornersRowsVanishes) {
  for (const double robust : {0.0, 2.0}) {
    const BundleState state = solved({.estimate_shape = true, .robust_scale_sigma = robust});
    std::map<std::string, std::pair<Eigen::VectorXd, Eigen::VectorXd>> sums;  // of each block: Jᵀr and |J|²
    for (const ViewData& view : used_views(world_.problem, state)) {
      const BoardShape& shape = state.shapes[view.target];
      ViewBlock block;
      ASSERT_TRUE(linearize_view(
          view,
          {state.cameras[view.camera].parameters.data(), state.camera_from_rig[view.camera],
           state.poses[view.pose].rig_from_target, Eigen::Vector3d(shape.bend_x_m, shape.bend_y_m, shape.twist_m)},
          {.with_shape = true, .robust_scale_sigma = robust}, block));
      const auto add = [&](const std::string& name, const ViewBlock::Rows& jacobian) {
        auto& [gradient, square] = sums[name];
        if (gradient.size() == 0) gradient = square = Eigen::VectorXd::Zero(jacobian.cols());
        gradient += jacobian.transpose() * block.residual;
        square += jacobian.colwise().squaredNorm().transpose();
      };
      add("intrinsics " + std::to_string(view.camera), block.wrt_intrinsics);
      if (view.camera != 0) add("camera_from_rig " + std::to_string(view.camera), block.wrt_camera_from_rig);
      add("pose " + std::to_string(view.pose), block.wrt_rig_from_target);
      add("shape", block.wrt_shape);
    }
    for (const auto& [name, sum] : sums) {
      const Eigen::VectorXd sigmas_off = sum.first.array() / sum.second.array().sqrt();
      // A solve ends where what is left moves no unknown by a thousandth of its sigma. Plain least squares falls faster
      // than it has to, and the step that is taken last is not seen; with the robust loss weights follow the residuals.
      EXPECT_LE(sigmas_off.cwiseAbs().maxCoeff(), robust > 0.0 ? 1e-3 : 1e-5) << name << ", robust " << robust;
    }
  }
}

// By a thousandth of a sigma the cost rises by half its square times the variance of the residuals.
TEST_F(NoisyStereo, SolvingOnMovesNothingByAThousandthOfItsSigma) {
  std::size_t residuals = 0;
  for (const auto& fates : start_.fates) residuals += 2 * std::ranges::count(fates, ObservationFate::kUsed);
  for (const double robust : {0.0, 2.0, 0.5}) {
    const BundleOptions options{.estimate_shape = true, .robust_scale_sigma = robust};
    BundleState state = start_;
    const BundleSummary summary = solve_bundle(world_.problem, state, options);
    const BundleSummary onward = solve_bundle(world_.problem, state, options);
    EXPECT_NEAR(summary.final_cost, onward.initial_cost, 1e-12 * summary.final_cost);  // told of the state as it is
    EXPECT_LE(onward.initial_cost - onward.final_cost, 1e-6 * onward.final_cost / static_cast<double>(residuals))
        << "robust " << robust;
  }
}

TEST_F(NoisyStereo, OrderOfViewsDoesNotMatter) {
  const BundleState expected = solved({});
  std::vector<std::size_t> order(world_.problem.views.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::shuffle(order.begin(), order.end(), std::mt19937(1));
  CalibrationProblem problem = world_.problem;
  BundleState state = start_;
  for (std::size_t v = 0; v < order.size(); ++v) {
    problem.views[v] = world_.problem.views[order[v]];
    state.pose_of_view[v] = start_.pose_of_view[order[v]];
    state.fates[v] = start_.fates[order[v]];
  }
  solve_bundle(problem, state);
  EXPECT_LE(largest_difference(state, expected), 1e-9);
}

TEST(RobustLoss, IgnoresFivePercentOutliers) {
  SyntheticOptions options = stereo_options();
  options.noise_px = 0.1;
  options.outlier_fraction = 0.05;
  const SyntheticWorld world = synthetic_world(options);
  const BundleState truth = true_state(world);
  BundleState clean = truth;  // what the same data give without the outliers
  for (std::size_t v = 0; v < clean.fates.size(); ++v) {
    for (std::size_t i = 0; i < clean.fates[v].size(); ++i) {
      if (world.outliers[v][i]) clean.fates[v][i] = ObservationFate::kOutlier;
    }
  }
  solve_bundle(world.problem, clean);
  BundleState robust = disturbed(truth);
  solve_bundle(world.problem, robust, {.robust_scale_sigma = 3.0});
  BundleState plain = disturbed(truth);
  solve_bundle(world.problem, plain);
  // A 5 to 50 px outlier keeps a pull of at most c²/s, 9/50 sigma; one in twenty of those in random directions moves
  // the answer by far less than its noise. Plain least squares is off by a hundred times more.
  const auto error = [&](const BundleState& state) {
    return (state.cameras[0].parameters.head<4>() - clean.cameras[0].parameters.head<4>()).norm();
  };
  EXPECT_LT(error(robust), 0.15);
  EXPECT_GT(error(plain), 5.0 * error(robust));
}

// Images of a pincushion lens, and a model that only knows barrels: it would need a beta below zero, which is no lens.
TEST(Projectability, ASolveThatTheModelStopsSaysSo) {
  SyntheticOptions options;
  options.cameras[0].model = "brown_conrady";
  options.cameras[0].focal_px = 700;
  options.cameras[0].shape = {0.2, 0.0, 0.0, 0.0, 0.0};
  options.max_off_axis_rad = 0.4;
  SyntheticWorld world = synthetic_world(options);
  BundleState state = true_state(world);
  world.problem.cameras[0].model = *model_named("extended_unified");
  state.cameras[0] = start_camera(world.problem.cameras[0].model, options.cameras[0].size, 700.0);
  world.problem.rules = {{"*.alpha", ParameterRule::Kind::kFixed, 0.5, 0.0}};
  const BundleSummary summary = solve_bundle(world.problem, state);
  EXPECT_EQ(summary.termination, Termination::kBlocked) << summary.message;
  EXPECT_NE(summary.message.find("steps were refused"), std::string::npos) << summary.message;
}

TEST(Projectability, CornersBehindAPinholeAreMarkedAndLeftOut) {
  SyntheticOptions options;
  options.cameras[0].model = "pinhole";
  options.cameras[0].focal_px = 700;
  options.max_off_axis_rad = 0.4;
  SyntheticWorld world = synthetic_world(options);
  Target& target = world.problem.targets[0];
  const int id = target.points.back().id + 1;
  target.points.push_back({id, Eigen::Vector3d(0, 0, -50)});  // behind every camera that faces the board
  for (TargetView& view : world.problem.views) view.observations.push_back({{100, 100}, 1.0, id});
  const BundleState truth = true_state(world);
  for (const auto& fates : truth.fates) {
    EXPECT_EQ(fates.back(), ObservationFate::kUnprojectable);
    EXPECT_EQ(std::ranges::count(fates, ObservationFate::kUsed), static_cast<std::ptrdiff_t>(fates.size()) - 1);
  }
  EXPECT_FALSE(view_residuals(world.problem, truth, 0).back().allFinite());
  BundleState state = disturbed(truth);
  mark_projectable(world.problem, state);
  solve_bundle(world.problem, state);
  EXPECT_LE(largest_difference(state, truth), 1e-8);

  // In use nonetheless: no made-up residual, the solve says which view it is, and nothing is changed.
  state = truth;
  state.fates[0].back() = ObservationFate::kUsed;
  const BundleSummary summary = solve_bundle(world.problem, state);
  EXPECT_EQ(summary.termination, Termination::kFailed);
  EXPECT_NE(summary.message.find(view_name(world.problem, world.problem.views[0])), std::string::npos)
      << summary.message;
  EXPECT_EQ(largest_difference(state, truth), 0.0);
}

TEST(Projectability, OutliersStayOutliersAndUnusedViewsAreSetAside) {
  const SyntheticWorld world = synthetic_world({});
  BundleState state = true_state(world);
  state.fates[1][0] = ObservationFate::kOutlier;
  state.pose_of_view[2] = -1;
  mark_projectable(world.problem, state);
  EXPECT_EQ(state.fates[1][0], ObservationFate::kOutlier);
  EXPECT_EQ(state.fates[2][0], ObservationFate::kViewSetAside);
  state.pose_of_view[2] = world.pose_of_view[2];
  mark_projectable(world.problem, state);
  EXPECT_EQ(state.fates[2][0], ObservationFate::kUsed);
}

}  // namespace
}  // namespace raybundle::testing
