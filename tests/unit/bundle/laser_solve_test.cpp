// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "laser_worlds.hpp"
#include "raybundle/bundle/information.hpp"

namespace raybundle::testing {
namespace {

BundleState solved(const LaserWorld& made, const BundleOptions& options = {}) {
  BundleState state = disturbed_beams(made.truth);
  const BundleSummary summary = solve_bundle(made.world.problem, state, options);
  EXPECT_EQ(summary.termination, Termination::kConverged) << summary.message;
  return state;
}

class NoisyBeams : public ::testing::TestWithParam<int> {  // views: few leave the poses, many the beams
 protected:
  LaserWorld made_ = laser_world(small_laser_rig(2, GetParam()), {.grid = {.rows = 5, .columns = 5}});
};
INSTANTIATE_TEST_SUITE_P(PosesOrBeams, NoisyBeams, ::testing::Values(8, 24));

TEST_P(NoisyBeams, ThreadsDoNotChangeABit) {
  const BundleState one = solved(made_, {.estimate_shape = true, .robust_scale_sigma = 2, .threads = 1});
  for (const int threads : {2, 5}) {
    const BundleState many = solved(made_, {.estimate_shape = true, .robust_scale_sigma = 2, .threads = threads});
    EXPECT_EQ(largest_difference(one, many), 0.0) << threads;
    for (std::size_t b = 0; b < one.beams.size(); ++b) {
      if (!one.beams[b]) continue;
      EXPECT_TRUE(one.beams[b]->point == many.beams[b]->point && one.beams[b]->direction == many.beams[b]->direction);
    }
  }
}

TEST_P(NoisyBeams, TheAnswerDoesNotDependOnWhereThePointsOfTheBeamsWere) {
  const BundleState expected = solved(made_);
  BundleState state = disturbed_beams(made_.truth);
  for (auto& beam : state.beams) {
    if (beam) beam->point = beam->at(3.0);
  }
  solve_bundle(made_.world.problem, state);
  EXPECT_LE(largest_difference(state, expected), 1e-7);
  EXPECT_LE(largest_beam_difference(state, expected), 1e-7);
}

TEST_P(NoisyBeams, PointsLieAmidTheirHits) {
  const BundleState state = solved(made_);
  std::vector<double> sum(state.beams.size(), 0.0);
  for (std::size_t v = 0; v < made_.world.problem.views.size(); ++v) {
    const TargetView& view = made_.world.problem.views[v];
    const Rigid3 target_from_rig = state.poses[state.pose_of_view[v]].rig_from_target.inverse();
    for (std::size_t i = 0; i < view.dots.size(); ++i) {
      if (state.dot_fates[v][i] != ObservationFate::kUsed) continue;
      const Line3& beam = *state.beams[view.dots[i].beam];
      sum[view.dots[i].beam] -= (target_from_rig * beam.point).z() / (target_from_rig.rotation * beam.direction).z();
    }
  }
  for (const double offset : sum) EXPECT_NEAR(offset, 0.0, 1e-9);
}

TEST_P(NoisyBeams, FixedCamerasStayAndBeamsComeOut) {
  made_.world.problem.rules = {{"*.intrinsics", ParameterRule::Kind::kFixed, {}, 0.0},
                               {"*.camera_from_rig", ParameterRule::Kind::kFixed, {}, 0.0}};
  BundleState start = disturbed_beams(made_.truth);
  start.cameras = made_.truth.cameras;
  start.camera_from_rig = made_.truth.camera_from_rig;
  BundleState state = start;
  const BundleSummary summary = solve_bundle(made_.world.problem, state);
  EXPECT_EQ(summary.termination, Termination::kConverged) << summary.message;
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    EXPECT_TRUE(state.cameras[c].parameters == start.cameras[c].parameters);
    EXPECT_TRUE(state.camera_from_rig[c].translation == start.camera_from_rig[c].translation);
  }
  EXPECT_LE(largest_beam_difference(state, made_.truth), 0.01);
  for (const auto& covariance : beam_covariances(made_.world.problem, state)) {
    EXPECT_EQ(covariance ? covariance->with_parameters.cols() : 0, 0);
  }
}

// One dot in twenty is half a dozen pixels off: least squares follows them, the robust loss does not.
TEST_P(NoisyBeams, RobustLossHoldsAgainstWrongDots) {
  int count = 0;
  for (TargetView& view : made_.world.problem.views) {
    for (Dot& dot : view.dots) {
      if (++count % 20 == 0) dot.pixel += Eigen::Vector2d(4.0, 5.0);
    }
  }
  const double plain = largest_beam_difference(solved(made_), made_.truth);
  const double robust = largest_beam_difference(solved(made_, {.robust_scale_sigma = 2}), made_.truth);
  EXPECT_LT(robust, 0.5 * plain);
}

// With a strong prior beside its dots a beam is where the prior is; with a weak one where the dots are.
TEST_P(NoisyBeams, PriorsPullBeams) {
  const BundleState free = solved(made_);
  const int beam = static_cast<int>(std::ranges::find_if(free.beams, [](const auto& b) { return b.has_value(); }) -
                                    free.beams.begin());
  const Line3 elsewhere = perturbed(*free.beams[beam], Eigen::Vector4d(0.002, -0.001, 0.003, 0.002));
  BundleOptions options;
  options.beam_priors.resize(free.beams.size());
  options.beam_priors[beam] = BeamPrior{elsewhere, 1e14 * Eigen::Matrix4d::Identity()};
  EXPECT_LE(motion_between(elsewhere, *solved(made_, options).beams[beam]).norm(), 1e-4);
  options.beam_priors[beam]->information = 1e-6 * Eigen::Matrix4d::Identity();
  EXPECT_LE(largest_beam_difference(solved(made_, options), free), 1e-6);
}

// A gradient that is not that of the cost would leave a prior's optimum elsewhere than where the cost is least.
TEST_P(NoisyBeams, PriorsAreAtTheirOptimum) {
  BundleOptions options;
  options.beam_priors.resize(made_.truth.beams.size());
  Eigen::Matrix4d information = Eigen::Vector4d(1e6, 2e6, 1e5, 3e5).asDiagonal();
  information(0, 2) = information(2, 0) = 2e5;
  for (std::size_t b = 0; b < options.beam_priors.size(); ++b) {
    if (!made_.truth.beams[b]) continue;
    Line3 mean = perturbed(*made_.truth.beams[b], Eigen::Vector4d(0.004, -0.003, 0.01, 0.02));
    mean.point = mean.at(-0.4);
    options.beam_priors[b] = BeamPrior{mean, information};
  }
  const BundleState optimum = solved(made_, options);
  const auto cost_at = [&](BundleState state) {
    return solve_bundle(made_.world.problem, state, {.beam_priors = options.beam_priors, .max_iterations = 0})
        .initial_cost;
  };
  const double least = cost_at(optimum);
  for (std::size_t b = 0; b < optimum.beams.size(); ++b) {
    if (!optimum.beams[b]) continue;
    for (int k = 0; k < 4; ++k) {
      const double step = 1e-5;
      BundleState plus = optimum, minus = optimum;
      plus.beams[b] = perturbed(*optimum.beams[b], step * Eigen::Vector4d::Unit(k));
      minus.beams[b] = perturbed(*optimum.beams[b], -step * Eigen::Vector4d::Unit(k));
      const double curvature = cost_at(plus) + cost_at(minus) - 2 * least;
      EXPECT_LE(std::abs(cost_at(plus) - cost_at(minus)), 1e-2 * curvature) << "beam " << b << ", " << k;
    }
  }
}

// A start whose beams run beside the boards is refused, not given made-up residuals.
TEST(Beams, StartWithoutPredictionFails) {
  LaserWorld made = laser_world(small_laser_rig(1, 8), {.grid = {.rows = 3, .columns = 3}});
  BundleState state = made.truth;
  for (auto& beam : state.beams) {
    if (beam) beam->direction = Eigen::Vector3d(0, 0, -1);
    if (beam) beam->point = Eigen::Vector3d(0, 0, -1e9);
  }
  state.beams[made.world.problem.views[0].dots[0].beam] = Line3{
      Eigen::Vector3d(0, 0, 1), state.poses[state.pose_of_view[0]].rig_from_target.rotation * Eigen::Vector3d::UnitX()};
  const BundleSummary summary = solve_bundle(made.world.problem, state);
  EXPECT_EQ(summary.termination, Termination::kFailed);
  EXPECT_NE(summary.message.find("dots"), std::string::npos) << summary.message;
}

// Over many noisy worlds errᵀ C⁻¹ err of all beams and cameras' parameters has mean n and variance 2n; so has each
// beam's own, but those of one world hang together.
class BeamScatter : public ::testing::TestWithParam<bool> {};  // whether the cameras are held where they truly are
INSTANTIATE_TEST_SUITE_P(CamerasHeld, BeamScatter, ::testing::Bool());

TEST_P(BeamScatter, AgreesWithTheCovarianceOverSeeds) {
  constexpr int kSeeds = 40;
  std::vector<double> of_world;
  double expected = 0.0, chi2 = 0.0, freedom = 0.0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    SyntheticOptions options = small_laser_rig(1, 16);
    options.noise_px = 0.1;
    const LaserOptions laser{.grid = {.rows = 4, .columns = 4}, .noise_px = 0.1, .seed = static_cast<unsigned>(seed)};
    options.seed = static_cast<unsigned>(seed);
    LaserWorld made = laser_world(options, laser);
    if (GetParam()) {
      made.world.problem.cameras[0].parameters = made.truth.cameras[0].parameters;
      made.world.problem.rules = {{"*.intrinsics", ParameterRule::Kind::kFixed, {}, 0.0}};
    }
    const BundleState state = solved(made);
    const auto covariances = beam_covariances(made.world.problem, state);
    double squared = 0.0;
    int count = 0;
    for (std::size_t b = 0; b < covariances.size(); ++b) {
      if (!covariances[b]) continue;
      const Eigen::Vector4d error = motion_between(*state.beams[b], *made.truth.beams[b]);
      squared += error.dot(covariances[b]->of_beam.ldlt().solve(error));
      count += 4;
    }
    of_world.push_back(squared / count);
    expected += 1.0;
    const ReducedInformation information = reduced_information(made.world.problem, state);
    chi2 += information.chi2;
    freedom += information.residuals - information.parameters;
  }
  double mean = 0.0, variance = 0.0;
  for (const double value : of_world) mean += value / kSeeds;
  for (const double value : of_world) variance += (value - mean) * (value - mean) / (kSeeds - 1);
  // 99.9 % of a normal distribution; the beams of one world are not independent, so that the scatter is measured.
  EXPECT_NEAR(mean, 1.0, 3.3 * std::sqrt(variance / kSeeds));
  EXPECT_LT(std::sqrt(variance / kSeeds), 0.15);
  EXPECT_NEAR(chi2 / freedom, 1.0, 3.3 * std::sqrt(2.0 / freedom));
}

}  // namespace
}  // namespace raybundle::testing
