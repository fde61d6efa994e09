// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/monitor.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "heap_calls.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/occupancy/learn.hpp"
#include "raybundle/synthetic/random.hpp"

namespace raybundle {
namespace {

constexpr int kRays = 144;
const Eigen::Vector3d kEye(0.46, 0.36, 0.90);

// Rays to a seat-like floor; somebody is a plate above it, whose front edge is at front_x [m].
std::vector<ScenePoint> scene(bool somebody, double front_x, double noise_m, std::uint64_t seed) {
  Random random(seed);
  std::vector<ScenePoint> points;
  for (int i = 0; i < kRays; ++i) {
    const int column = i % 12, row = i / 12;
    Eigen::Vector3d end(-0.5 + column * 0.1, -0.25 + row * 0.04, -0.1);
    if (somebody) {
      const double t = (kEye.z() - 0.4) / (kEye.z() - end.z());  // where the ray meets the plate's height
      const Eigen::Vector3d on_plate = kEye + t * (end - kEye);
      if (on_plate.x() < front_x) end = on_plate;
    }
    points.push_back({i, end + noise_m * Eigen::Vector3d(random.normal(), random.normal(), random.normal()), 0.005});
  }
  return points;
}

Scan scan_of(const std::vector<ScenePoint>& points) {
  return {.viewpoint_in_vehicle = kEye, .points = points, .rays = kRays};
}

const LearnOptions kQuick{.known_share = 1.0, .layers = {8, 4}, .steps = 200, .dropout = 0.0};

// @param twins  whether half of those who may be fired at are of another group, whom nothing tells from the others
LabelledCases labelled(bool twins) {
  const int count = twins ? 160 : 80;
  LabelledCases cases{.attribute_set = std::string(kStripes.name),
                      .situations = {{.name = "empty", .group = 0, .inert = true}, {.name = "adult", .group = 1}},
                      .group_names = {"empty", "something"},
                      .attributes = Eigen::MatrixXd(kStripes.size, count),
                      .classes = {},
                      .actions = {}};
  if (twins) {
    cases.situations.push_back({.name = "twin", .group = 2});
    cases.group_names.emplace_back("another");
  }
  for (int n = 0; n < count; ++n) {
    const bool adult = n % 2 == 1;
    cases.attributes.col(n) = kStripes.attributes({}, {}, scan_of(scene(adult, 0.2, 0.005, 1 + n)));
    cases.classes.push_back(static_cast<std::uint8_t>(twins && n % 4 == 3 ? 2 : adult));
    cases.actions.push_back(adult ? AirbagAction::kFire : AirbagAction::kNoFire);
  }
  return cases;
}

CaseBase base(bool twins = false) {
  CaseBase base = learn(labelled(twins), kQuick);
  base.sure_of_group = base.sure_of_situation = 0.6;  // 80 cases are too few to prove that any votes are right
  return base;
}

const CaseBase& shared_base() {
  static const CaseBase learnt = base();
  return learnt;
}

Occupancy after(OccupancyMonitor& monitor, const std::vector<ScenePoint>& points, int frames) {
  Occupancy answer;
  for (int i = 0; i < frames; ++i) answer = monitor.process(scan_of(points));
  return answer;
}

TEST(Monitor, AnEmptySeatIsNotFiredAtAndAPassengerIs) {
  OccupancyMonitor monitor({}, shared_base(), kRays);
  const Occupancy empty = after(monitor, scene(false, 0.0, 0.003, 900), 3);
  EXPECT_EQ(empty.state, State::kOk);
  EXPECT_EQ(empty.group, 0);
  EXPECT_EQ(empty.action, AirbagAction::kNoFire);
  monitor.restart();
  const Occupancy adult = after(monitor, scene(true, 0.2, 0.003, 901), 3);
  EXPECT_EQ(adult.group, 1);
  EXPECT_EQ(adult.action, AirbagAction::kFire);
}

// Whoever it is, whatever the votes: something in the critical zone forbids to fire, in that very frame; what allows
// has to last.
TEST(Monitor, NoFireIsNeverDelayedAndFireIs) {
  MonitorOptions options;
  options.calm_frames = 3;
  OccupancyMonitor monitor({}, shared_base(), kRays, options);
  const std::vector<ScenePoint> far = scene(true, 0.2, 0.0, 902);
  std::vector<ScenePoint> near = far;
  near[40].x_in_vehicle = {0.6, 0.0, 0.5};
  EXPECT_EQ(after(monitor, far, 3).action, AirbagAction::kFire);
  EXPECT_EQ(after(monitor, near, 1).action, AirbagAction::kNoFire);
  EXPECT_EQ(after(monitor, far, 2).action, AirbagAction::kNoFire);
  EXPECT_EQ(after(monitor, far, 1).action, AirbagAction::kFire);
}

// A screen on the dashboard stands in the critical zone, and is always there.
TEST(Monitor, AFixtureForbidsNothing) {
  VehicleLayout layout;
  std::vector<ScenePoint> points = scene(true, 0.2, 0.0, 904);
  points[40].x_in_vehicle = {0.6, 0.0, 0.5};
  OccupancyMonitor unaware(layout, shared_base(), kRays);
  EXPECT_EQ(after(unaware, points, 3).action, AirbagAction::kNoFire);
  layout.fixtures[0] = Eigen::AlignedBox3d(Eigen::Vector3d(0.58, -0.1, 0.45), Eigen::Vector3d(0.62, 0.1, 0.55));
  OccupancyMonitor aware(layout, shared_base(), kRays);
  EXPECT_EQ(after(aware, points, 3).action, AirbagAction::kFire);
}

// The seat and whoever sits on it 10 cm to the rear of where the cases were learnt are the same as there; without a
// word of the seat they are not.
TEST(Monitor, CasesMoveWithTheSeat) {
  const Eigen::Vector3d back(-0.10, 0.0, 0.0);
  std::vector<ScenePoint> points = scene(true, 0.2, 0.0, 905);
  Scan scan = scan_of(points);
  OccupancyMonitor monitor({}, shared_base(), kRays);
  const double there = monitor.process(scan).verdict.distance;
  for (ScenePoint& point : points) point.x_in_vehicle += back;
  scan.viewpoint_in_vehicle += back;
  SeatPose seat;
  seat.bight += Eigen::Vector2d(back.x(), back.z());
  monitor.restart();
  const Attributes here = kStripes.attributes({}, seat, scan), unmoved = kStripes.attributes({}, {}, scan);
  const Attributes learnt = kStripes.attributes({}, {}, scan_of(scene(true, 0.2, 0.0, 905)));
  const int profile = static_cast<int>(learnt.size()) - 9;  // all but the rays before the dashboard, which stays
  EXPECT_TRUE(here.tail(profile).isApprox(learnt.tail(profile), 1e-9));
  EXPECT_FALSE(unmoved.tail(profile).isApprox(learnt.tail(profile), 1e-3));
  const double moved = monitor.process(scan, seat).verdict.distance,
               as_it_stands = monitor.process(scan).verdict.distance;
  EXPECT_LT(std::abs(moved - there), 0.5 * std::abs(as_it_stands - there));
}

TEST(Monitor, SomethingInTheOuterZoneIsFiredAtGently) {
  CaseBase knows_all = shared_base();
  for (CaseSpace& space : knows_all.spaces) space.farthest = 1e9;
  OccupancyMonitor monitor({}, knows_all, kRays);
  std::vector<ScenePoint> points = scene(true, 0.2, 0.0, 903);
  points[40].x_in_vehicle = {0.42, 0.0, 0.5};
  EXPECT_EQ(after(monitor, points, 3).action, AirbagAction::kDepowered);
}

// A sensor that says nothing, or that something is wrong with, gives no answer at all.
TEST(Monitor, InvalidIsNoDefault) {
  OccupancyMonitor monitor({}, shared_base(), kRays);
  const std::vector<ScenePoint> points = scene(false, 0.0, 0.0, 904);
  Scan broken = scan_of(points);
  broken.state = State::kInvalid;
  const Scan nothing{.viewpoint_in_vehicle = kEye, .points = {}, .rays = kRays};
  for (const Scan& scan : {broken, nothing}) {
    const Occupancy answer = monitor.process(scan);
    EXPECT_EQ(answer.state, State::kInvalid);
    EXPECT_EQ(answer.action, AirbagAction::kUndecided);
    EXPECT_EQ(answer.group, -1);
  }
}

// A scan of another sensor says nothing, wherever its points lie; and what was before it says nothing of what follows.
TEST(Monitor, AScanOfOtherRaysIsInvalid) {
  const std::vector<ScenePoint> adult = scene(true, 0.2, 0.0, 915);
  std::vector<ScenePoint> beyond = adult, negative = adult, twice = adult;
  beyond[7].ray = kRays;
  negative[7].ray = -1;
  twice.push_back(adult[0]);
  Scan fewer = scan_of(adult), more = scan_of(adult);
  fewer.rays = kRays - 1;
  more.rays = kRays + 1;
  OccupancyMonitor monitor({}, shared_base(), kRays);
  for (const Scan& scan : {scan_of(beyond), scan_of(negative), scan_of(twice), fewer, more}) {
    ASSERT_EQ(after(monitor, adult, 3).action, AirbagAction::kFire);
    const Occupancy answer = monitor.process(scan);
    EXPECT_EQ(answer.state, State::kInvalid);
    EXPECT_EQ(answer.action, AirbagAction::kUndecided);
    EXPECT_EQ(answer.group, -1);
    EXPECT_EQ(after(monitor, adult, 2).action, AirbagAction::kUndecided);
  }
}

// What the base has never seen: everything half a metre nearer to the eye.
TEST(Monitor, WhatIsFarFromAllCasesIsUndecided) {
  OccupancyMonitor monitor({}, shared_base(), kRays);
  std::vector<ScenePoint> points = scene(false, 0.0, 0.0, 905);
  for (ScenePoint& point : points) point.x_in_vehicle = 0.5 * (point.x_in_vehicle + kEye) - Eigen::Vector3d(0.4, 0, 0);
  EXPECT_EQ(after(monitor, points, 3).state, State::kInvalid);
}

// What moves is not an empty seat.
TEST(Monitor, MotionSpeaksAgainstWhatIsInert) {
  OccupancyMonitor monitor({}, shared_base(), kRays);
  const std::vector<ScenePoint> still = scene(false, 0.0, 0.0, 906);
  std::vector<ScenePoint> moved = still;
  for (int i = 0; i < kRays; i += 8) moved[i].x_in_vehicle += 0.08 * (kEye - moved[i].x_in_vehicle).normalized();
  EXPECT_EQ(after(monitor, still, 2).situation, 0);
  const Occupancy answer = after(monitor, moved, 1);
  EXPECT_GT(answer.moving, 0.04);
  EXPECT_NE(answer.situation, 0);
}

// Who is there changes rarely: one frame of another kind changes what is told only when nothing is remembered.
TEST(Monitor, WhoIsThereIsSaidByTheFramesOfTheLastSecond) {
  MonitorOptions forgetful;
  forgetful.memory_frames = 1;
  OccupancyMonitor monitor({}, shared_base(), kRays), other({}, shared_base(), kRays, forgetful);
  const std::vector<ScenePoint> adult = scene(true, 0.2, 0.0, 908), empty = scene(false, 0.0, 0.0, 909);
  EXPECT_EQ(after(monitor, adult, 9).group, 1);
  EXPECT_EQ(after(monitor, empty, 1).group, 1);
  EXPECT_EQ(after(monitor, empty, 9).group, 0);
  EXPECT_EQ(after(other, adult, 9).group, 1);
  EXPECT_NE(after(other, empty, 1).group, 1);
}

const MonitorOptions kDense = [] {
  MonitorOptions options;
  options.dense = true;
  return options;
}();

// With dense points the votes of a second allow: nine frames of ten would. The tenth forbids by itself.
TEST(Monitor, WhatIsRememberedNeverDelaysNoFire) {
  OccupancyMonitor monitor({}, shared_base(), kRays, kDense);
  EXPECT_EQ(after(monitor, scene(true, 0.2, 0.0, 910), 9).action, AirbagAction::kFire);
  EXPECT_EQ(after(monitor, scene(false, 0.0, 0.0, 911), 1).action, AirbagAction::kNoFire);
}

// The same frames, dense or not: a second of an empty seat speaks against firing at whoever sits down only where
// frames are asked together; a gap between makes it forgotten.
TEST(Monitor, WithDensePointsTheLastSecondAllows) {
  const std::vector<ScenePoint> empty = scene(false, 0.0, 0.0, 912), adult = scene(true, 0.2, 0.0, 913);
  Scan gap = scan_of(empty);
  gap.state = State::kInvalid;
  OccupancyMonitor dense({}, shared_base(), kRays, kDense), sparse({}, shared_base(), kRays);
  after(dense, empty, 10);
  after(sparse, empty, 10);
  EXPECT_NE(after(dense, adult, 4).action, AirbagAction::kFire);
  EXPECT_EQ(after(sparse, adult, 4).action, AirbagAction::kFire);
  EXPECT_EQ(after(dense, adult, 10).action, AirbagAction::kFire);
  after(dense, empty, 10);
  dense.process(gap);
  EXPECT_EQ(after(dense, adult, 4).action, AirbagAction::kFire);
}

// Where points show all that is in the zones, it need not be known who is behind them.
TEST(Monitor, WithDensePointsNoGroupIsNeededToFire) {
  CaseBase unsure = base(true);
  unsure.sure_of_group = 0.9;
  OccupancyMonitor dense({}, unsure, kRays, kDense), sparse({}, unsure, kRays);
  const std::vector<ScenePoint> adult = scene(true, 0.2, 0.0, 914);
  EXPECT_EQ(after(dense, adult, 4).group, -1);
  EXPECT_EQ(after(dense, adult, 1).action, AirbagAction::kFire);
  EXPECT_NE(after(sparse, adult, 5).action, AirbagAction::kFire);
}

TEST(Monitor, TakesNoHeapAfterStartAndGivesTheSameBits) {
  OccupancyMonitor monitor({}, shared_base(), kRays), other({}, shared_base(), kRays);
  const std::vector<ScenePoint> points = scene(true, 0.2, 0.003, 907);
  const long before = testing::heap_calls;
  Occupancy answer;
  for (int i = 0; i < 20; ++i) answer = monitor.process(scan_of(points));
  EXPECT_EQ(testing::heap_calls, before);
  const Occupancy same = after(other, points, 20);
  EXPECT_EQ(answer.verdict.distance, same.verdict.distance);
  EXPECT_EQ(answer.verdict.votes, same.verdict.votes);
}

TEST(Learn, RefusesWhatItHasNoRoomFor) {
  const auto refused = [](auto&& change) {
    LabelledCases cases = labelled(false);
    LearnOptions options = kQuick;
    change(cases, options);
    EXPECT_THROW(learn(cases, options), Error);
  };
  refused([](LabelledCases&, LearnOptions& options) { options.neighbours = 150; });
  refused([](LabelledCases&, LearnOptions& options) { options.layers = {2000, 4}; });
  refused([](LabelledCases&, LearnOptions& options) { options.layers = {}; });
  refused([](LabelledCases&, LearnOptions& options) { options.layers.assign(9, 4); });
  refused([](LabelledCases&, LearnOptions& options) { options.dropout = 1.0; });
  refused([](LabelledCases&, LearnOptions& options) { options.steps = 0; });
  refused([](LabelledCases&, LearnOptions& options) { options.spaces = 0; });
  refused([](LabelledCases&, LearnOptions& options) { options.known_share = 1.5; });
  refused([](LabelledCases& cases, LearnOptions&) { cases.situations[1].group = 5000; });
  refused([](LabelledCases& cases, LearnOptions&) { cases.classes[3] = 200; });
}

TEST(Monitor, ABaseOfUnknownAttributesIsRefused) {
  CaseBase other = shared_base();
  other.attribute_set = "stripes-0";
  EXPECT_THROW(OccupancyMonitor({}, other, kRays), Error);
}

}  // namespace
}  // namespace raybundle
