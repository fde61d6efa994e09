// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/residual_bias.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "uncertainty_worlds.hpp"

namespace raybundle::testing {
namespace {

// The residuals of the true answer, with `shift` added to each corner's pixel.
template <typename Shift>
ResidualBias bias_of(const SyntheticWorld& world, Shift&& shift) {
  CalibrationResult result;
  result.poses = world.poses;
  const BundleState truth = true_state(world);
  for (int v = 0; v < static_cast<int>(world.problem.views.size()); ++v) {
    ViewResult view;
    view.pose = world.pose_of_view[v];
    view.fates = truth.fates[v];
    view.residuals_px = view_residuals(world.problem, truth, v);
    for (std::size_t i = 0; i < view.residuals_px.size(); ++i) {
      view.residuals_px[i] += shift(world.problem.views[v].observations[i].pixel);
    }
    result.views.push_back(view);
  }
  return residual_bias(world.problem, result, 0, world.cameras[0]);
}

SyntheticWorld world_of(unsigned seed) {
  SyntheticOptions options = fisheye_options(seed);
  options.frames = 60;
  return synthetic_world(options);
}

// What noise alone leaves of the bias shrinks with the corners of a part: some 60 views of 63 in some 30 parts.
TEST(ResidualBias, OfNoiseIsNone) {
  int significant = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const ResidualBias bias = bias_of(world_of(seed), [](const auto&) { return Eigen::Vector2d(0, 0); });
    EXPECT_LT(bias.bias_px, 0.02);
    EXPECT_NEAR(bias.noise_px, 0.2 * std::sqrt(2.0), 0.02);
    significant += bias.significant();
  }
  EXPECT_LE(significant, 1);
}

TEST(ResidualBias, OfAWrongLensIsItsSizeAndPlace) {
  const Eigen::Vector2d centre(640, 480);
  const auto radial = [&](const Eigen::Vector2d& pixel) -> Eigen::Vector2d {
    return 0.1 * (pixel - centre).squaredNorm() / (300.0 * 300.0) * (pixel - centre).normalized();
  };
  const SyntheticWorld world = world_of(3);
  const ResidualBias bias = bias_of(world, radial);
  double squares = 0.0;
  int corners = 0;
  for (const TargetView& view : world.problem.views) {
    for (const Observation& observation : view.observations) {
      squares += radial(observation.pixel).squaredNorm();
      ++corners;
    }
  }
  EXPECT_TRUE(bias.significant());
  EXPECT_NEAR(bias.bias_px, std::sqrt(squares / corners), 0.25 * bias.bias_px);  // a part is not one place
  EXPECT_NEAR(bias.bias_px * bias.bias_px + bias.noise_px * bias.noise_px, bias.rms_px * bias.rms_px, 1e-12);
  // Radial in all bands, and the more the farther off the axis.
  ASSERT_GE(bias.bands.size(), 4u);
  EXPECT_GT(bias.bands[3].mean_px.x(), 3.0 * std::abs(bias.bands[3].mean_px.y()));
  EXPECT_GT(bias.bands[3].mean_px.x(), bias.bands[1].mean_px.x());
}

}  // namespace
}  // namespace raybundle::testing
