// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/scene/problem.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "raybundle/geometry/error.hpp"
#include "synthetic_world.hpp"

namespace raybundle {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

CalibrationProblem good_problem() {
  testing::SyntheticOptions options;
  options.frames = 3;
  return testing::synthetic_world(options).problem;
}

std::string message_after(const std::function<void(CalibrationProblem&)>& damage) {
  CalibrationProblem problem = good_problem();
  damage(problem);
  try {
    check(problem);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
    return error.what();
  }
  return "accepted";
}

TEST(ProblemCheck, AcceptsASoundProblem) { EXPECT_NO_THROW(check(good_problem())); }

TEST(ProblemCheck, NamesTheViewThatIsWrong) {
  const auto first = [](CalibrationProblem& problem) -> Observation& { return problem.views[0].observations[0]; };
  const CalibrationProblem good = good_problem();
  const std::string view = view_name(good, good.views[0]);
  const std::vector<std::pair<std::function<void(CalibrationProblem&)>, std::string>> damages{
      {[&](auto& p) { first(p).pixel.x() = kNan; }, "not a finite number"},
      {[&](auto& p) { first(p).pixel.y() = 1e5; }, "far outside"},
      {[&](auto& p) { first(p).point_id = 4711; }, "4711 is not on the board"},
      {[&](auto& p) { first(p).sigma_px = 0.0; }, "sigma"},
      {[&](auto& p) { first(p).sigma_px = kNan; }, "sigma"},
      {[&](auto& p) { first(p).point_id = p.views[0].observations[1].point_id; }, "observed twice"},
      {[&](auto& p) { p.views.push_back(p.views[0]); }, "given twice"},
  };
  for (const auto& [damage, text] : damages) {
    EXPECT_THAT(message_after(damage), ::testing::AllOf(::testing::HasSubstr(view), ::testing::HasSubstr(text)));
  }
}

TEST(ProblemCheck, TellsSharesOfTheImageFromPixels) {
  const auto divide = [](CalibrationProblem& problem) {
    for (TargetView& view : problem.views) {
      for (Observation& observation : view.observations) observation.pixel /= 1e4;
    }
  };
  EXPECT_THAT(message_after(divide), ::testing::HasSubstr("give u and v in pixels"));
}

TEST(ProblemCheck, NamesTheCameraRuleOrTargetThatIsWrong) {
  using ::testing::HasSubstr;
  EXPECT_THAT(message_after([](auto& p) { p.cameras.clear(); }), HasSubstr("no camera"));
  EXPECT_THAT(message_after([](auto& p) { p.targets.clear(); }), HasSubstr("no target"));
  EXPECT_THAT(message_after([](auto& p) { p.cameras[0].parameters = Eigen::VectorXd::Ones(1); }),
              HasSubstr("has 1 start parameters"));
  EXPECT_THAT(message_after([](auto& p) { p.cameras.push_back(p.cameras[0]); }), HasSubstr("two cameras are called"));
  EXPECT_THAT(message_after([](auto& p) { p.targets.push_back(p.targets[0]); }), HasSubstr("two boards are called"));
  EXPECT_THAT(message_after([](auto& p) { p.cameras[0].size = {}; }), HasSubstr("image size"));
  EXPECT_THAT(message_after([](auto& p) { std::swap(p.targets[0].points[0], p.targets[0].points[1]); }),
              HasSubstr("sorted by id"));
  EXPECT_THAT(message_after([](auto& p) { p.views[0].camera = 7; }), HasSubstr("view 0 names a camera"));
  EXPECT_THAT(message_after([](auto& p) { p.views[0].frame = -1; }), HasSubstr("view 0 names a camera"));
  EXPECT_THAT(message_after([](auto& p) {
                p.rules.push_back({"*.k1", ParameterRule::Kind::kPrior, {}, 0.0});
              }),
              HasSubstr("the prior on '*.k1' needs a positive sigma"));
  for (const auto kind : {ParameterRule::Kind::kFixed, ParameterRule::Kind::kPrior}) {
    EXPECT_THAT(message_after([&](auto& p) {
                  p.rules.push_back({"*.k1", kind, kNan, 1.0});
                }),
                HasSubstr("the value for '*.k1' is not a finite number"));
  }
}

// relabel() looks the ids up, for every point.
TEST(ProblemCheck, ASymmetryNamesEachPointOnce) {
  const auto with = [](const auto& change) {
    return message_after([&](CalibrationProblem& problem) {
      Target& target = problem.targets[0];
      TargetSymmetry turned;
      for (const TargetPoint& point : target.points) turned.ids.insert(turned.ids.begin(), point.id);
      change(turned.ids);
      target.symmetries = {turned};
    });
  };
  const auto refused = ::testing::HasSubstr("a symmetry does not name each of the board's points once");
  EXPECT_EQ(with([](auto&) {}), "accepted");
  EXPECT_THAT(with([](auto& ids) { ids.pop_back(); }), refused);
  EXPECT_THAT(with([](auto& ids) { ids.push_back(ids[0]); }), refused);
  EXPECT_THAT(with([](auto& ids) { ids[0] = 4711; }), refused);
  EXPECT_THAT(with([](auto& ids) { ids[0] = ids[1]; }), refused);
}

TEST(ProblemCheck, NamesTheBeamThatIsWrong) {
  const auto with = [](const ProblemLaser& laser) {
    return message_after([&](CalibrationProblem& problem) { problem.laser = laser; });
  };
  const LaserGrid grid{.rows = 3, .columns = 4};
  EXPECT_EQ(with({.grid = grid, .anchor = LaserAnchor{.beam = 11}, .brightest = 11, .missing = {0, 11}}), "accepted");
  for (const int beam : {-1, 12}) {
    EXPECT_THAT(with({.grid = grid, .anchor = LaserAnchor{.beam = beam}}), ::testing::HasSubstr("the anchor"));
    EXPECT_THAT(with({.grid = grid, .brightest = beam}), ::testing::HasSubstr("brightest"));
    EXPECT_THAT(with({.grid = grid, .missing = {0, beam}}), ::testing::HasSubstr("missing"));
  }
  EXPECT_THAT(with({.grid = {.rows = 1 << 16, .columns = 1 << 16}}), ::testing::HasSubstr("rows or columns"));
  EXPECT_THAT(with({.grid = {.rows = 0, .columns = 4}}), ::testing::HasSubstr("at least 1"));
}

TEST(ProblemCheck, NamesTheDotThatIsWrong) {
  const auto dotted = [](auto damage) {
    return message_after([&](CalibrationProblem& problem) {
      problem.laser = ProblemLaser{.grid = {.rows = 3, .columns = 4}};
      problem.views[1].dots = {Dot{.beam = 5}, Dot{.beam = 6}, Dot{}};
      damage(problem);
    });
  };
  const auto first = [](CalibrationProblem& problem) -> Dot& { return problem.views[1].dots[0]; };
  EXPECT_EQ(dotted([](auto&) {}), "accepted");
  EXPECT_THAT(dotted([](auto& problem) { problem.laser.reset(); }), ::testing::HasSubstr("has no laser"));
  EXPECT_THAT(dotted([&](auto& problem) { first(problem).pixel.x() = kNan; }), ::testing::HasSubstr("dot 0"));
  EXPECT_THAT(dotted([&](auto& problem) { first(problem).covariance_px2(0, 1) = 0.5; }),
              ::testing::HasSubstr("symmetric"));
  EXPECT_THAT(dotted([&](auto& problem) { first(problem).covariance_px2(1, 1) = -1; }),
              ::testing::HasSubstr("positive definite"));
  EXPECT_THAT(dotted([&](auto& problem) { first(problem).brightness = -1; }), ::testing::HasSubstr("brightness"));
  EXPECT_THAT(dotted([&](auto& problem) { first(problem).beam = 12; }), ::testing::HasSubstr("3x4 beams"));
  EXPECT_THAT(dotted([&](auto& problem) { first(problem).beam = 6; }), ::testing::HasSubstr("row 1, column 2"));
}

}  // namespace
}  // namespace raybundle
