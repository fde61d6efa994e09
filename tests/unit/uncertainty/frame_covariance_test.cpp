// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/frame_covariance.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <random>

#include "raybundle/bundle/view_block.hpp"
#include "uncertainty_worlds.hpp"

namespace raybundle::testing {
namespace {

struct BothCovariances {
  Covariance plain, by_frame;
  int frames = 0;
};

// Corners of a view that err together: their rows are stretched, as by a lens model that does not fit there.
void stretch_views(SyntheticWorld& world, double share, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, share);
  for (TargetView& view : world.problem.views) {
    const double slope[] = {normal(random), normal(random)};
    for (Observation& o : view.observations) {
      const Eigen::Vector2d r = (o.pixel - Eigen::Vector2d(640, 480)) / 100.0;
      o.pixel += Eigen::Vector2d(slope[0] * r.x() * std::abs(r.x()), slope[1] * r.y() * std::abs(r.y()));
    }
  }
}

BothCovariances covariances_of(const SyntheticWorld& world, const BundleOptions& options = {}) {
  BundleState state = true_state(world);
  solve_bundle(world.problem, state, options);
  const ReducedInformation all = reduced_information(world.problem, state, options);
  const std::vector<FrameInformation> frames = information_by_frame(world.problem, state, options);
  return {covariance(all).covariance, covariance_by_frame(all, frames).value(), static_cast<int>(frames.size())};
}

// Each frame's by the textbook: JᵀJ and Jᵀr of its views, the pose eliminated by a Schur complement. At the truth,
// where the noise pulls.
TEST(FrameInformation, IsTheSchurComplementOfTheFramesRows) {
  const SyntheticWorld world = synthetic_world(stereo_options(2));
  const BundleState state = true_state(world);
  const Eigen::VectorXd scale =
      reduced_information(world.problem, state).information.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::Index n = scale.size();
  const std::vector<FrameInformation> frames = information_by_frame(world.problem, state);
  EXPECT_GT(frames.size(), 15U);
  for (const FrameInformation& frame : frames) {
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n + 6, n + 6);
    Eigen::VectorXd pull = Eigen::VectorXd::Zero(n + 6);
    double chi2 = 0.0;
    for (const ViewData& view : used_views(world.problem, state)) {
      if (state.poses[view.pose].frame != frame.frame) continue;
      ViewBlock block;
      ASSERT_TRUE(linearize_view(view,
                                 {state.cameras[view.camera].parameters.data(), state.camera_from_rig[view.camera],
                                  state.poses[view.pose].rig_from_target},
                                 {}, block));
      Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(block.residual.size(), n + 6);
      jacobian.middleCols(8 * view.camera, 8) = block.wrt_intrinsics;
      if (view.camera == 1) jacobian.middleCols(16, 6) = block.wrt_camera_from_rig;
      jacobian.rightCols(6) = block.wrt_rig_from_target;
      normal += jacobian.transpose() * jacobian;
      pull += jacobian.transpose() * block.residual;
      chi2 += block.residual.squaredNorm();
    }
    const Eigen::LDLT<Eigen::MatrixXd> of_pose(normal.bottomRightCorner(6, 6));
    const Eigen::MatrixXd across = normal.topRightCorner(n, 6);
    const Eigen::MatrixXd information = normal.topLeftCorner(n, n) - across * of_pose.solve(across.transpose());
    const Eigen::VectorXd gradient = pull.head(n) - across * of_pose.solve(pull.tail(6));
    // The complement is a difference of numbers 1e4 times as large.
    const Eigen::MatrixXd difference = scale.asDiagonal() * (frame.information - information) * scale.asDiagonal();
    EXPECT_LE(difference.cwiseAbs().maxCoeff(), 1e-8);
    EXPECT_LE(scale.cwiseProduct(frame.gradient - gradient).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_NEAR(frame.chi2, chi2, 1e-9 * chi2);
    EXPECT_EQ(frame.pose_directions, 6);
  }
}

// A solve is over when no unknown is off its optimum by more than a thousandth of its sigma.
TEST(FrameInformation, OfAllFramesPullsNowhereAtTheOptimum) {
  const SyntheticWorld world = synthetic_world(stereo_options(2));
  BundleState state = true_state(world);
  solve_bundle(world.problem, state);
  const Eigen::MatrixXd covariance = reduced_information(world.problem, state).information.inverse();
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(covariance.rows());
  for (const FrameInformation& frame : information_by_frame(world.problem, state)) gradient += frame.gradient;
  const Eigen::ArrayXd off_sigmas = (covariance * gradient).array() / covariance.diagonal().array().sqrt();
  EXPECT_LT(off_sigmas.abs().maxCoeff(), 1e-3);
}

// With independent corners the variances by frame have the plain ones as their expectation. A variance of one
// parameter scatters by sqrt(2 / frames), and parameters of a world are correlated: count each world once.
TEST(FrameCovariance, OfIndependentCornersIsThePlainOneOnAverage) {
  constexpr int kSeeds = 40;
  double sum = 0.0;
  int count = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const BothCovariances both = covariances_of(synthetic_world(fisheye_options(seed)));
    for (const FrameScatter& scatter : frame_scatter(both.plain, both.by_frame)) {
      sum += scatter.ratio * scatter.ratio;
      ++count;
    }
  }
  EXPECT_NEAR(sum / count, 1.0, 4 * std::sqrt(2.0 / 20 / kSeeds));
}

// Errors that the corners of a view share scatter the estimates by more than the plain sigmas say, and by what the
// sigmas by frame say.
TEST(FrameCovariance, KnowsTheScatterOfCornersThatErrTogether) {
  constexpr int kSeeds = 60;
  double squared = 0.0, plain = 0.0, by_frame = 0.0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    SyntheticOptions options = fisheye_options(seed);
    options.frames = 40;
    SyntheticWorld world = synthetic_world(options);
    stretch_views(world, 0.02, seed);
    BundleState state = true_state(world);
    solve_bundle(world.problem, state);
    const ReducedInformation all = reduced_information(world.problem, state);
    const Covariance frames = covariance_by_frame(all, information_by_frame(world.problem, state)).value();
    squared += std::pow(state.cameras[0].parameters[2] - world.cameras[0].parameters[2], 2);
    plain += std::pow(covariance(all).covariance.sigma("camera0.cx"), 2);
    by_frame += std::pow(frames.sigma("camera0.cx"), 2);
  }
  EXPECT_GT(squared / plain, 2.0);
  EXPECT_NEAR(squared / by_frame, 1.0, 4 * std::sqrt(2.0 / kSeeds));  // four standard deviations
}

TEST(FrameCovariance, WarnsInWordsOnlyWhenItIsMaterial) {
  SyntheticOptions options = fisheye_options(5);
  options.frames = 30;
  SyntheticWorld world = synthetic_world(options);
  const BothCovariances honest = covariances_of(world);
  EXPECT_EQ(frame_scatter_warning(honest.plain, honest.by_frame, honest.frames), std::nullopt);
  stretch_views(world, 0.05, 1);
  const BothCovariances correlated = covariances_of(world);
  const auto warning = frame_scatter_warning(correlated.plain, correlated.by_frame, correlated.frames);
  ASSERT_TRUE(warning);
  EXPECT_THAT(*warning, ::testing::HasSubstr("err together"));
  EXPECT_THAT(*warning, ::testing::HasSubstr("times"));
}

TEST(FrameCovariance, PriorsKeepTheirSigmas) {
  SyntheticWorld world = synthetic_world(fisheye_options(3));
  world.problem.rules = {{"camera0.cx", ParameterRule::Kind::kPrior, world.cameras[0].parameters[2], 1e-4}};
  const BothCovariances both = covariances_of(world);
  const double plain = both.plain.sigma("camera0.cx");
  EXPECT_NEAR(both.by_frame.sigma("camera0.cx"), plain, 0.02 * plain);
}

TEST(FrameCovariance, NeedsFramesEnough) {
  SyntheticOptions options = fisheye_options(1);
  options.frames = kFewestFrames - 1;
  const SyntheticWorld world = synthetic_world(options);
  const BundleState state = true_state(world);
  EXPECT_FALSE(
      covariance_by_frame(reduced_information(world.problem, state), information_by_frame(world.problem, state)));
}

}  // namespace
}  // namespace raybundle::testing
