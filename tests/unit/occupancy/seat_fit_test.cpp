// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/seat_fit.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <vector>

#include "raybundle/synthetic/random.hpp"

namespace raybundle {
namespace testing {
extern std::atomic<long> heap_calls;  // of this binary: heap_calls.hpp
}
namespace {

const Eigen::Vector3d kEye(0.46, 0.36, 0.90);

// The flat middle of an empty seat, measured at random places.
std::vector<ScenePoint> seat_points(const SeatPose& seat, double sigma_m) {
  Random random(3);
  std::vector<ScenePoint> points;
  for (int i = 0; i < 800; ++i) {
    const bool back = i % 2 == 1;
    const double along = random.uniform(0.0, back ? 0.6 : 0.46), across = random.uniform(-0.2, 0.2);
    const Eigen::Vector2d place = seat.bight + along * (back ? seat.back_up() : seat.cushion_forward());
    const Eigen::Vector3d x(place.x(), across, place.y());
    points.push_back({i, x + sigma_m * random.normal() * (x - kEye).normalized(), sigma_m});
  }
  return points;
}

SeatFit fit(const std::vector<ScenePoint>& points) {
  return fit_seat({}, {.viewpoint_in_vehicle = kEye, .points = points, .rays = 1000});
}

TEST(SeatFit, TakesNoHeap) {
  const std::vector<ScenePoint> points = seat_points({}, 0.005);
  const Scan scan{.viewpoint_in_vehicle = kEye, .points = points, .rays = 1000};
  const long before = testing::heap_calls;
  const SeatFit found = fit_seat({}, scan);
  EXPECT_EQ(testing::heap_calls, before);
  EXPECT_TRUE(found.found);
}

// Anywhere in the travel that the car allows, the truth comes back: to a tenth of what is asked without noise.
TEST(SeatFit, FindsTrackAndRecline) {
  for (const double track : {-0.11, 0.0, 0.11}) {
    for (const double recline : {0.25, 0.40, 0.60}) {
      const SeatPose truth{{-0.15 + track, -0.10}, recline, 0.21};
      const SeatFit found = fit(seat_points(truth, 0.0));
      ASSERT_TRUE(found.found) << track << " " << recline;
      EXPECT_LT((found.pose.bight - truth.bight).norm(), 1e-3);
      EXPECT_NEAR(found.pose.recline_rad, recline, 3e-3);
      EXPECT_NEAR(found.pose.cushion_pitch_rad, 0.21, 3e-3);
    }
  }
}

// Noise of 1 cm a point: the bight within 1 cm, the back within 2°, and both within five of the sigmas that it tells.
TEST(SeatFit, TellsHowSureItIs) {
  const SeatPose truth{{-0.12, -0.12}, 0.35, 0.20};
  const SeatFit found = fit(seat_points(truth, 0.01));
  ASSERT_TRUE(found.found);
  const Eigen::Vector2d error = found.pose.bight - truth.bight;
  EXPECT_LT(error.norm(), 0.01);
  EXPECT_LT(std::abs(found.pose.recline_rad - truth.recline_rad), 0.035);
  EXPECT_LT(std::abs(error.x()), 5 * found.bight_sigma_m.x());
  EXPECT_LT(std::abs(error.y()), 5 * found.bight_sigma_m.y());
  EXPECT_LT(std::abs(found.pose.recline_rad - truth.recline_rad), 5 * found.recline_sigma_rad);
}

// A box on the cushion hides a part of the seat: the lines may be those of the box.
TEST(SeatFit, AnOccupiedSeatIsNotFound) {
  const SeatPose truth{{-0.14, -0.11}, 0.4, 0.21};
  std::vector<ScenePoint> points = seat_points(truth, 0.0);
  const int free = static_cast<int>(points.size());
  for (int i = 0; i < 300; ++i) points.push_back({free + i, {0.0 + 0.001 * i, 0.0, 0.20}, 0.001});
  const SeatFit found = fit(points);
  EXPECT_FALSE(found.found);
  EXPECT_GT(found.hidden, 0.15);
}

// Errors that a whole frame has in common do not show in its scatter; between frames they do, and shrink in the mean.
TEST(SeatWatch, AveragesFramesAndTellsTheirScatter) {
  Random random(5);
  SeatWatch watch;
  EXPECT_FALSE(watch.seat().found);
  watch.add({});
  EXPECT_EQ(watch.frames(), 0);
  constexpr int kFrames = 100;
  for (int i = 0; i < kFrames; ++i) {
    SeatFit fit;
    fit.found = true;
    fit.bight_sigma_m = {1e-4, 1e-4};
    fit.pose.bight = {-0.1 + 0.01 * random.normal(), -0.1};
    watch.add(fit);
  }
  const SeatFit seat = watch.seat();
  EXPECT_TRUE(seat.found);
  EXPECT_NEAR(seat.pose.bight.x(), -0.1, 0.004);       // four sigmas of the mean
  EXPECT_NEAR(seat.bight_sigma_m.x(), 0.001, 0.0003);  // a hundred frames tell a scatter to 7 %
}

// Whoever sits down hides the seat: it is told as it was, and for how long it was not seen. A seat that is seen
// elsewhere was moved: the mean of both would be neither.
TEST(SeatWatch, KeepsAHiddenSeatAndForgetsOneThatWasMoved) {
  SeatFit fit;
  fit.found = true;
  fit.pose.bight = {-0.10, -0.11};
  SeatWatch watch;
  for (int i = 0; i < 5; ++i) watch.add(fit);
  for (int i = 0; i < 3; ++i) watch.add({});
  EXPECT_EQ(watch.seat().pose.bight, fit.pose.bight);
  EXPECT_EQ(watch.frames_since_seen(), 3);
  fit.pose.bight.x() += 0.10;
  watch.add(fit);
  EXPECT_EQ(watch.frames(), 1);
  EXPECT_EQ(watch.frames_since_seen(), 0);
  EXPECT_EQ(watch.seat().pose.bight, fit.pose.bight);
}

// A crate as wide as the cushion is as flat as one, but no seat lifts so far.
TEST(SeatFit, ACrateThatCoversTheCushionIsNoSeat) {
  const SeatPose seat;
  std::vector<ScenePoint> points = seat_points(seat, 0.002);
  for (ScenePoint& point : points) {
    if (seat.before_back(point.x_in_vehicle) > 0.02) point.x_in_vehicle.z() += 0.12;
  }
  EXPECT_FALSE(fit(points).found);
}

TEST(SeatFit, AHiddenSeatIsNotFound) {
  EXPECT_FALSE(fit({}).found);
  std::vector<ScenePoint> points = seat_points({}, 0.0);
  for (ScenePoint& point : points) point.x_in_vehicle += 0.3 * (kEye - point.x_in_vehicle);
  EXPECT_FALSE(fit(points).found);
}

}  // namespace
}  // namespace raybundle
