// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "../../../calib_core/bundle/src/normal_equations.hpp"
#include "laser_worlds.hpp"
#include "raybundle/bundle/information.hpp"

namespace raybundle::testing {
namespace {

// All unknowns of a problem with two cameras of eight intrinsics: cameras, poses, then beams that the state holds.
struct AllUnknowns {
  const LaserWorld& made;
  std::vector<int> beams = {};

  explicit AllUnknowns(const LaserWorld& world) : made(world) {
    for (int b = 0; b < static_cast<int>(made.truth.beams.size()); ++b) {
      if (made.truth.beams[b]) beams.push_back(b);
    }
  }
  static constexpr int kParameters = 22;
  int first_beam() const { return kParameters + 6 * static_cast<int>(made.truth.poses.size()); }
  int count() const { return first_beam() + 4 * static_cast<int>(beams.size()); }

  BundleState moved(const BundleState& state, int k, double step) const {
    BundleState result = state;
    if (k < 8) {
      result.cameras[0].parameters[k] += step;
    } else if (k < 16) {
      result.cameras[1].parameters[k - 8] += step;
    } else if (k < first_beam()) {
      Rigid3& pose = k < 22 ? result.camera_from_rig[1] : result.poses[(k - 22) / 6].rig_from_target;
      pose = perturbed(pose, step * Eigen::Matrix<double, 6, 1>::Unit(k < 22 ? k - 16 : (k - 22) % 6));
    } else {
      Line3& beam = *result.beams[beams[(k - first_beam()) / 4]];
      beam = perturbed(beam, step * Eigen::Vector4d::Unit((k - first_beam()) % 4));
    }
    return result;
  }

  // Whitened: sigmas of the worlds below are all the same.
  Eigen::VectorXd residuals(const BundleState& state, double corner_sigma_px, double dot_sigma_px) const {
    std::vector<double> values;
    for (int v = 0; v < static_cast<int>(made.world.problem.views.size()); ++v) {
      for (const Eigen::Vector2d& r : view_residuals(made.world.problem, state, v)) {
        values.insert(values.end(), {r.x() / corner_sigma_px, r.y() / corner_sigma_px});
      }
      for (const Eigen::Vector2d& r : dot_residuals(made.world.problem, state, v)) {
        if (r.allFinite()) values.insert(values.end(), {r.x() / dot_sigma_px, r.y() / dot_sigma_px});
      }
    }
    return Eigen::Map<Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  }

  Eigen::MatrixXd normal_matrix() const {
    const double step = 1e-5;
    const double corner_sigma_px = made.world.problem.views[0].observations[0].sigma_px;
    const auto at = [&](int k, double by) { return residuals(moved(made.truth, k, by), corner_sigma_px, 0.1); };
    Eigen::MatrixXd jacobian(at(0, 0).size(), count());
    for (int k = 0; k < count(); ++k) jacobian.col(k) = (at(k, step) - at(k, -step)) / (2 * step);
    return jacobian.transpose() * jacobian;
  }
};

class BeamCovariances : public ::testing::TestWithParam<int> {  // views: few leave the poses, many the beams
 protected:
  LaserWorld made_ = laser_world(small_laser_rig(2, GetParam()), {.grid = {.rows = 4, .columns = 4}}, 2);
};
INSTANTIATE_TEST_SUITE_P(PosesOrBeams, BeamCovariances, ::testing::Values(6, 16));

void expect_block(const Eigen::MatrixXd& found, const Eigen::MatrixXd& expected, const Eigen::VectorXd& row_sigmas,
                  const Eigen::VectorXd& column_sigmas) {
  const Eigen::MatrixXd difference =
      row_sigmas.cwiseInverse().asDiagonal() * (found - expected) * column_sigmas.cwiseInverse().asDiagonal();
  EXPECT_LE(difference.cwiseAbs().maxCoeff(), 1e-4);  // derivatives are numeric, and inverted
}

TEST_P(BeamCovariances, AreBlocksOfTheInverseOfTheWholeNormalMatrix) {
  const AllUnknowns all(made_);
  const auto found = beam_covariances(made_.world.problem, made_.truth);
  const Eigen::MatrixXd inverse = all.normal_matrix().ldlt().solve(Eigen::MatrixXd::Identity(all.count(), all.count()));
  const Eigen::VectorXd sigmas = inverse.diagonal().cwiseSqrt();
  // By names: camera by camera, intrinsics and then extrinsics.
  std::vector<int> columns(22);
  for (int k = 0; k < 22; ++k) columns[k] = k;
  ASSERT_GE(all.beams.size(), 5U);
  for (std::size_t i = 0; i < all.beams.size(); ++i) {
    const auto& covariance = found[all.beams[i]];
    ASSERT_TRUE(covariance);
    const int first = all.first_beam() + 4 * static_cast<int>(i);
    expect_block(covariance->of_beam, inverse.block<4, 4>(first, first), sigmas.segment(first, 4),
                 sigmas.segment(first, 4));
    expect_block(covariance->with_parameters, inverse(Eigen::seqN(first, 4), columns), sigmas.segment(first, 4),
                 sigmas.head(22));
  }
  const ReducedInformation information = reduced_information(made_.world.problem, made_.truth);
  ASSERT_EQ(information.names.size(), 22U);
  EXPECT_EQ(information.parameters, all.count());
  EXPECT_EQ(information.residuals, all.residuals(made_.truth, 1, 1).size());
  expect_block(information.information.inverse(), inverse.topLeftCorner(22, 22), sigmas.head(22), sigmas.head(22));
}

TEST_P(BeamCovariances, PosesFirstAndBeamsFirstAreTheSameStep) {
  const BundleState state = disturbed_beams(made_.truth);
  NormalEquations equations(made_.world.problem, state, {});
  Linearization here;
  ASSERT_TRUE(equations.linearize(Unknowns(state), here));
  Elimination<6, 4> poses_first(here.system);
  Elimination<4, 6> beams_first(here.system);
  Workers workers(2);
  ASSERT_TRUE(poses_first.reduce(here.system, 1e4, workers) && poses_first.factor(poses_first.kept(), workers));
  ASSERT_TRUE(beams_first.reduce(here.system, 1e4, workers) && beams_first.factor(beams_first.kept(), workers));
  const BlockStep a = poses_first.step(here.system), b = beams_first.step(here.system);
  // Rounding, by the condition of the damped equations.
  EXPECT_LE((a.parameters - b.parameters).norm(), 1e-8 * a.parameters.norm());
  EXPECT_LE((a.poses - b.poses).norm(), 1e-8 * a.poses.norm());
  EXPECT_LE((a.beams - b.beams).norm(), 1e-8 * a.beams.norm());
  EXPECT_NEAR(a.predicted_decrease, b.predicted_decrease, 1e-9 * a.predicted_decrease);
}

// A beam with dots in one place only has no direction; the others do not mind it.
TEST_P(BeamCovariances, NothingForABeamThatOneBoardMet) {
  const auto before = beam_covariances(made_.world.problem, made_.truth);
  const int beam = AllUnknowns(made_).beams[0];
  bool met = false;
  for (std::size_t v = 0; v < made_.truth.dot_fates.size(); ++v) {
    const std::vector<Dot>& dots = made_.world.problem.views[v].dots;
    for (std::size_t i = 0; i < dots.size(); ++i) {
      if (dots[i].beam != beam) continue;
      if (met) made_.truth.dot_fates[v][i] = ObservationFate::kOutlier;
      met = true;
    }
  }
  const auto after = beam_covariances(made_.world.problem, made_.truth);
  EXPECT_FALSE(after[beam]);
  for (std::size_t b = 0; b < after.size(); ++b) {
    if (!after[b]) continue;
    const Eigen::Vector4d narrow = before[b]->of_beam.diagonal(), wide = after[b]->of_beam.diagonal();
    EXPECT_TRUE((wide.array() >= narrow.array() * (1 - 1e-9)).all());
    EXPECT_TRUE((wide.array() <= narrow.array() * 2).all());
  }
  const ReducedInformation information = reduced_information(made_.world.problem, made_.truth);
  EXPECT_TRUE(information.information.allFinite());

  BundleState state = disturbed_beams(made_.truth);
  const BundleSummary summary = solve_bundle(made_.world.problem, state);
  EXPECT_EQ(summary.termination, Termination::kConverged) << summary.message;

  BundleOptions options;
  options.beam_priors.resize(made_.truth.beams.size());
  options.beam_priors[beam] = BeamPrior{*made_.truth.beams[beam], 1e4 * Eigen::Matrix4d::Identity()};
  const auto with_prior = beam_covariances(made_.world.problem, made_.truth, options);
  ASSERT_TRUE(with_prior[beam]);
  EXPECT_LE(with_prior[beam]->of_beam.diagonal().maxCoeff(), 1e-4 * (1 + 1e-6));
  EXPECT_GE(with_prior[beam]->of_beam.diagonal().maxCoeff(), 1e-5);
}

}  // namespace
}  // namespace raybundle::testing
