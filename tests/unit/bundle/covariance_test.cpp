// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/covariance.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "bundle_worlds.hpp"
#include "raybundle/bundle/view_block.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle::testing {
namespace {

// Estimate minus truth in the order of the covariance.
Eigen::VectorXd error_of(const SyntheticWorld& world, const BundleState& state) {
  const int intrinsics = static_cast<int>(state.cameras[0].parameters.size());
  Eigen::VectorXd error(2 * intrinsics + 6);
  error << state.cameras[0].parameters - world.cameras[0].parameters,
      state.cameras[1].parameters - world.cameras[1].parameters,
      motion_between(world.camera_from_rig[1], state.camera_from_rig[1]);
  return error;
}

// Over many noisy worlds, errᵀ C⁻¹ err has mean n and variance 2n; and the variance factor mean one.
TEST(Covariance, AgreesWithTheScatterOverSeeds) {
  constexpr int kSeeds = 40;
  double squared = 0.0;
  double factor = 0.0;
  double freedom = 0.0;
  Eigen::Index n = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    SyntheticOptions options = stereo_options();
    options.frames = 14;
    options.noise_px = 0.2;
    options.seed = static_cast<unsigned>(seed);
    const SyntheticWorld world = synthetic_world(options);
    BundleState state = true_state(world);
    ASSERT_EQ(solve_bundle(world.problem, state).termination, Termination::kConverged);
    const ReducedInformation information = reduced_information(world.problem, state);
    const CovarianceResult result = covariance(information);
    const Eigen::VectorXd error = error_of(world, state);
    n = error.size();
    ASSERT_EQ(result.covariance.matrix.rows(), n);
    squared += error.dot(result.covariance.matrix.ldlt().solve(error));
    factor += result.variance_factor;
    freedom += information.residuals - information.parameters;
  }
  // Five standard deviations of the means.
  const double size = static_cast<double>(n);
  EXPECT_NEAR(squared / kSeeds, size, 5 * std::sqrt(2 * size / kSeeds));
  EXPECT_NEAR(factor / kSeeds, 1.0, 5 * std::sqrt(2 / freedom));
}

class Information : public ::testing::Test {
 protected:
  Information() {
    SyntheticOptions options = stereo_options();
    options.noise_px = 0.2;
    options.frames = 10;
    world_ = synthetic_world(options);
    state_ = true_state(world_);
    solve_bundle(world_.problem, state_);
  }
  SyntheticWorld world_;
  BundleState state_;
};

TEST_F(Information, CountsResidualsAndParameters) {
  int corners = 0;
  double chi2 = 0.0;
  for (int v = 0; v < static_cast<int>(world_.problem.views.size()); ++v) {
    for (const Eigen::Vector2d& residual : view_residuals(world_.problem, state_, v)) {
      chi2 += residual.squaredNorm() / (0.2 * 0.2);
      ++corners;
    }
  }
  world_.problem.rules = {{"camera0.cx", ParameterRule::Kind::kPrior, {}, 1.0},
                          {"camera0.cy", ParameterRule::Kind::kFixed, {}, 0.0}};
  const ReducedInformation information = reduced_information(world_.problem, state_);
  EXPECT_EQ(information.residuals, 2 * corners + 1);
  EXPECT_EQ(information.parameters, 15 + 6 + 6 * 10);
  EXPECT_NEAR(information.chi2, chi2, 1e-9 * chi2);
  EXPECT_EQ(information.names.size(), 21u);
}

// The same information by the textbook: the whole JᵀJ with the poses eliminated by a Schur complement.
TEST_F(Information, IsTheSchurComplementOfTheNormalEquations) {
  const ReducedInformation information = reduced_information(world_.problem, state_);
  const Eigen::Index n = information.information.rows();
  const Eigen::Index poses = static_cast<Eigen::Index>(6 * state_.poses.size());
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n + poses, n + poses);
  for (const ViewData& view : used_views(world_.problem, state_)) {
    ViewBlock block;
    ASSERT_TRUE(linearize_view(view,
                               {state_.cameras[view.camera].parameters.data(), state_.camera_from_rig[view.camera],
                                state_.poses[view.pose].rig_from_target},
                               {}, block));
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(block.residual.size(), n + poses);
    jacobian.middleCols(8 * view.camera, 8) = block.wrt_intrinsics;
    if (view.camera == 1) jacobian.middleCols(16, 6) = block.wrt_camera_from_rig;
    jacobian.middleCols(n + 6 * view.pose, 6) = block.wrt_rig_from_target;
    normal += jacobian.transpose() * jacobian;
  }
  const Eigen::MatrixXd schur =
      normal.topLeftCorner(n, n) -
      normal.topRightCorner(n, poses) *
          normal.bottomRightCorner(poses, poses).ldlt().solve(normal.bottomLeftCorner(poses, n));
  const Eigen::VectorXd scale = schur.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd difference = scale.asDiagonal() * (schur - information.information) * scale.asDiagonal();
  EXPECT_LE(difference.cwiseAbs().maxCoeff(), 1e-8);  // the complement is a difference of numbers 1e4 times as large
}

TEST_F(Information, FixingWhatIsKnownNarrowsTheRest) {
  const double free = covariance(reduced_information(world_.problem, state_)).covariance.sigma("camera0.cx");
  world_.problem.rules = {{"camera0.fx", ParameterRule::Kind::kFixed, {}, 0.0}};
  const Covariance fixed = covariance(reduced_information(world_.problem, state_)).covariance;
  EXPECT_LE(fixed.sigma("camera0.cx"), free * (1 + 1e-9));
  EXPECT_EQ(fixed.sigma("camera0.fx"), 0.0);
}

// A board always parallel to the image cannot tell focal length from distance.
TEST(Covariance, NamesADirectionThatIsNotSeen) {
  SyntheticOptions options;
  options.cameras[0].model = "pinhole";
  options.cameras[0].focal_px = 600;
  options.frames = 6;
  options.max_tilt_rad = 0.0;
  options.max_off_axis_rad = 0.0;
  options.noise_px = 0.3;
  const SyntheticWorld world = synthetic_world(options);
  const BundleState state = true_state(world);
  const CovarianceResult result = covariance(reduced_information(world.problem, state));
  EXPECT_TRUE(result.unseen);
  EXPECT_THAT(result.weak_parameters, ::testing::Contains(::testing::HasSubstr("camera0.f")));
  EXPECT_GT(result.covariance.sigma("camera0.fx"), 600.0);
}

TEST(Covariance, NamesTheWeakestDirection) {
  const double epsilon = 1e-11;  // a and b are almost one parameter; c is known by itself
  ReducedInformation information{.names = {"a", "b", "c"},
                                 .information = Eigen::Matrix3d{{1, 1 - epsilon, 0}, {1 - epsilon, 1, 0}, {0, 0, 4}},
                                 .chi2 = 20.0,
                                 .residuals = 13,
                                 .parameters = 3};
  const CovarianceResult weak = covariance(information);
  EXPECT_THAT(weak.weak_parameters, ::testing::UnorderedElementsAre("a", "b"));
  EXPECT_NEAR(weak.condition_number, 2 / epsilon, 1e-3 * 2 / epsilon);
  EXPECT_DOUBLE_EQ(weak.variance_factor, 2.0);
  EXPECT_NEAR(weak.covariance.sigma("c"), std::sqrt(2.0 / 4.0), 1e-12);
  information.information = Eigen::Matrix3d::Identity();
  EXPECT_TRUE(covariance(information).weak_parameters.empty());
}

}  // namespace
}  // namespace raybundle::testing
