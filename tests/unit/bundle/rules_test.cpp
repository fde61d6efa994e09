// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bundle_worlds.hpp"
#include "raybundle/bundle/information.hpp"
#include "raybundle/bundle/parameters.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle::testing {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;
using Kind = ParameterRule::Kind;

class Rules : public ::testing::Test {
 protected:
  Rules() {
    SyntheticOptions options = stereo_options();
    options.noise_px = 0.2;
    world_ = synthetic_world(options);
    start_ = disturbed(true_state(world_));
  }

  BundleState solved(const std::vector<ParameterRule>& rules, const BundleOptions& options = {}) {
    world_.problem.rules = rules;
    BundleState state = start_;
    const BundleSummary summary = solve_bundle(world_.problem, state, options);
    EXPECT_EQ(summary.termination, Termination::kConverged) << summary.message;
    return state;
  }

  std::vector<std::string> names(const BundleState& state, const BundleOptions& options = {}) const {
    return reduced_information(world_.problem, state, options).names;
  }

  SyntheticWorld world_;
  BundleState start_;
};

TEST_F(Rules, FixedParametersStayAndTheOthersMove) {
  const BundleState state = solved({{"camera0.fx", Kind::kFixed, {}, 0}, {"*.k4", Kind::kFixed, 0.0, 0}});
  EXPECT_EQ(state.cameras[0].parameters[0], start_.cameras[0].parameters[0]);
  EXPECT_NE(state.cameras[0].parameters[1], start_.cameras[0].parameters[1]);
  EXPECT_EQ(state.cameras[0].parameters[7], 0.0);
  EXPECT_EQ(state.cameras[1].parameters[7], 0.0);
  EXPECT_THAT(names(state), Not(Contains("camera1.k4")));
  EXPECT_THAT(names(state), Contains("camera1.fx"));
}

TEST_F(Rules, FixedMeansTheStartThatTheProblemGives) {
  world_.problem.cameras[1].parameters = world_.cameras[1].parameters;
  world_.problem.cameras[1].camera_from_rig = world_.camera_from_rig[1];
  const BundleState state = solved({{"camera1.*", Kind::kFixed, {}, 0}});
  EXPECT_EQ(state.cameras[1].parameters, world_.cameras[1].parameters);
  EXPECT_EQ(state.camera_from_rig[1].translation, world_.camera_from_rig[1].translation);
  EXPECT_EQ(state.camera_from_rig[1].rotation.coeffs(), world_.camera_from_rig[1].rotation.coeffs());
}

TEST_F(Rules, ExtrinsicsOnly) {
  start_.cameras = world_.cameras;
  const BundleState state = solved({{"*.intrinsics", Kind::kFixed, {}, 0}});
  EXPECT_EQ(state.cameras[0].parameters, world_.cameras[0].parameters);
  EXPECT_LT((state.camera_from_rig[1].translation - world_.camera_from_rig[1].translation).norm(), 5e-4);
  EXPECT_EQ(names(state).size(), 6u);
}

TEST_F(Rules, IntrinsicsOnly) {
  start_.camera_from_rig = world_.camera_from_rig;
  const BundleState state = solved({{"*.camera_from_rig", Kind::kFixed, {}, 0}});
  EXPECT_EQ(state.camera_from_rig[1].translation, world_.camera_from_rig[1].translation);
  EXPECT_EQ(names(state).size(), 16u);
}

TEST_F(Rules, PosesOnly) {
  start_.cameras = world_.cameras;
  start_.camera_from_rig = world_.camera_from_rig;
  const BundleState state = solved({{"camera?.*", Kind::kFixed, {}, 0}});
  EXPECT_LT(angle_between(state.poses[0].rig_from_target, world_.poses[0].rig_from_target), 0.01);
  EXPECT_TRUE(names(state).empty());
}

TEST_F(Rules, OneComponentOfThePoseCanBeFixed) {
  const BundleState state = solved({{"camera1.camera_from_rig.translation_x", Kind::kFixed, -0.125, 0}});
  EXPECT_EQ(state.camera_from_rig[1].translation.x(), -0.125);
  EXPECT_NE(state.camera_from_rig[1].translation.y(), start_.camera_from_rig[1].translation.y());
  EXPECT_THAT(names(state), Contains("camera1.camera_from_rig.rotation_x"));
  EXPECT_THAT(names(state), Not(Contains("camera1.camera_from_rig.translation_x")));
}

TEST_F(Rules, LaterRulesOverrideEarlierOnes) {
  const BundleState state = solved({{"*", Kind::kFixed, {}, 0}, {"camera0.cx", Kind::kFree, {}, 0}});
  EXPECT_EQ(names(state), std::vector<std::string>{"camera0.cx"});
}

// A prior and the data are two measurements of one number: the answer is their mean by weight. The data's own weight is
// the inverse of the variance of the parameter when all others are free.
TEST_F(Rules, PriorIsOneMoreMeasurement) {
  for (const auto& [name, sigma, offset] :
       {std::tuple{"camera0.cx", 0.05, 0.1}, std::tuple{"camera1.camera_from_rig.translation_x", 1e-4, 2e-4},
        std::tuple{"camera1.camera_from_rig.rotation_y", 1e-4, 2e-4}}) {
    const BundleState free = solved({});
    const ReducedInformation data = reduced_information(world_.problem, free);
    const auto i = std::ranges::find(data.names, name) - data.names.begin();
    const double data_variance = data.information.inverse()(i, i);
    const auto value = [&](const BundleState& state) {
      if (i == 2) return state.cameras[0].parameters[2];
      return motion_between(free.camera_from_rig[1], state.camera_from_rig[1])[i - 16];
    };
    ParameterRule rule{name, Kind::kPrior, {}, sigma};
    start_ = free;  // without a value the prior pulls to the start
    if (i == 2) {
      start_.cameras[0].parameters[2] += offset;
    } else {
      start_.camera_from_rig[1] =
          perturbed(free.camera_from_rig[1], offset * Eigen::Matrix<double, 6, 1>::Unit(i - 16));
    }
    const BundleState state = solved({rule});
    const double expected = offset * data_variance / (data_variance + sigma * sigma);
    // To first order; the curvature over a fraction of a sigma is small.
    EXPECT_NEAR(value(state) - value(free), expected, 0.01 * expected) << name;
    start_ = disturbed(true_state(world_));
  }
}

TEST_F(Rules, TightPriorHoldsAtItsValue) {
  const BundleState state = solved({{"camera0.fx", Kind::kPrior, 385.0, 1e-7},
                                    {"camera1.camera_from_rig.translation_x", Kind::kPrior, -0.123, 1e-9}});
  EXPECT_NEAR(state.cameras[0].parameters[0], 385.0, 1e-6);
  EXPECT_NEAR(state.camera_from_rig[1].translation.x(), -0.123, 1e-7);
}

TEST_F(Rules, BoardShape) {
  const BundleOptions options{.estimate_shape = true};
  const BundleState state =
      solved({{"board0.bend_x", Kind::kFixed, 0.001, 0}, {"board0.twist", Kind::kPrior, 0.0, 1e-9}}, options);
  EXPECT_EQ(state.shapes[0].bend_x_m, 0.001);
  EXPECT_NEAR(state.shapes[0].twist_m, 0.0, 1e-8);
  EXPECT_NE(state.shapes[0].bend_y_m, 0.0);
  EXPECT_THAT(names(state, options), Contains("board0.bend_y"));
  EXPECT_THAT(names(state), Not(Contains("board0.bend_y")));
}

TEST_F(Rules, RuleThatMatchesNothingNamesWhatThereIs) {
  world_.problem.rules = {{"left.fx", Kind::kFixed, {}, 0}};
  try {
    solve_bundle(world_.problem, start_);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
    EXPECT_THAT(error.what(), HasSubstr("left.fx"));
    EXPECT_THAT(error.what(), HasSubstr("camera1.camera_from_rig.translation_x"));
  }
  world_.problem.rules = {{"camera0.fx", Kind::kPrior, 1.0, 0.0}};
  EXPECT_THROW(solve_bundle(world_.problem, start_), Error);
}

TEST_F(Rules, AFocalLengthOfZeroOrLessIsRefused) {
  for (const ParameterRule& rule : {ParameterRule{"camera0.fx", Kind::kFixed, -500.0, 0},
                                    {"*.fy", Kind::kPrior, -500.0, 5},
                                    {"camera1.intrinsics", Kind::kFixed, 0.0, 0}}) {
    world_.problem.rules = {rule};
    try {
      parameter_blocks(world_.problem);
      ADD_FAILURE() << rule.pattern << " was taken";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
      EXPECT_THAT(error.what(), HasSubstr("'" + rule.pattern + "' sets camera"));
    }
  }
}

}  // namespace
}  // namespace raybundle::testing
