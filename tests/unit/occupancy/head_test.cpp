// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/head.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
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
constexpr double kStep_rad = 0.015;  // between rays

struct Shape {
  Eigen::Vector3d centre, semi_axes;
  double turn_rad = 0.0;
};

// Distance to the front of an ellipsoid along a ray of unit length; infinite when it is missed.
double distance_to(const Shape& shape, const Eigen::Vector3d& ray) {
  const Eigen::AngleAxisd turn(-shape.turn_rad, Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d from = (turn * (kEye - shape.centre)).cwiseQuotient(shape.semi_axes);
  const Eigen::Vector3d along = (turn * ray).cwiseQuotient(shape.semi_axes);
  const double a = along.squaredNorm(), b = from.dot(along), c = from.squaredNorm() - 1.0;
  return b * b < a * c ? INFINITY : (-b - std::sqrt(b * b - a * c)) / a;
}

// Rays over the seat end on what they meet first, at the latest on the back of the seat or a wall behind it.
std::vector<ScenePoint> seen(const std::vector<Shape>& shapes, double sigma_m) {
  Random random(5);
  std::vector<ScenePoint> points;
  const SeatPose seat;
  int ray_number = 0;
  for (double across = -0.8; across < 0.8; across += kStep_rad) {
    for (double up = -0.9; up < 0.7; up += kStep_rad, ++ray_number) {
      const Eigen::Vector3d ahead = (Eigen::Vector3d(-0.1, 0.0, 0.5) - kEye).normalized(),
                            left = ahead.cross(Eigen::Vector3d::UnitZ()).normalized();
      const Eigen::Vector3d ray = (ahead + across * left + up * left.cross(ahead)).normalized();
      double range = (-0.9 - kEye.x()) / ray.x();  // the wall
      const Eigen::Vector2d to_seat(seat.bight.x() - kEye.x(), seat.bight.y() - kEye.z()), back = seat.back_up();
      const double on_back =
          (to_seat.x() * back.y() - to_seat.y() * back.x()) / (ray.x() * back.y() - ray.z() * back.x());
      const Eigen::Vector3d place = kEye + on_back * ray;
      if (on_back > 0.0 && place.z() < 0.5 && std::abs(place.y()) < 0.25) range = std::min(range, on_back);
      for (const Shape& shape : shapes) range = std::min(range, distance_to(shape, ray));
      if (range < 0.0 || range > 2.0) continue;
      points.push_back({ray_number, kEye + (range + sigma_m * random.normal()) * ray, sigma_m});
    }
  }
  return points;
}

Head found_among(const std::vector<ScenePoint>& points, const HeadOptions& options = {}) {
  return find_head({}, {}, {.viewpoint_in_vehicle = kEye, .points = points, .rays = 20000}, options);
}

Head found_in(const std::vector<Shape>& shapes, double sigma_m, const HeadOptions& options = {}) {
  return found_among(seen(shapes, sigma_m), options);
}

const Shape kBody{{-0.05, 0.0, 0.22}, {0.13, 0.20, 0.28}};
// The head and hair that are seen of a head whose centre is to be told.
Shape head_at(const Eigen::Vector3d& centre, double turn_rad, double size = 1.0) {
  const HeadOptions options;
  const Eigen::AngleAxisd turn(turn_rad, Eigen::Vector3d::UnitZ());
  return {centre - turn * options.centre_from_hair_m,
          options.semi_axes_m.array() * (std::log(size) * options.growth).array().exp(), turn_rad};
}

// Wherever a head may be and look: 1 cm is what a size that is not known leaves of a front that is seen exactly.
TEST(Head, IsFoundWhereItIs) {
  for (const Eigen::Vector3d& centre :
       {Eigen::Vector3d(-0.10, 0.0, 0.62), Eigen::Vector3d(0.10, 0.10, 0.58), Eigen::Vector3d(-0.02, -0.12, 0.60)}) {
    for (const double turn : {-0.6, 0.0, 0.6}) {
      const Head head = found_in({kBody, head_at(centre, turn)}, 0.002);
      ASSERT_TRUE(head.found) << centre.transpose() << ", " << turn;
      EXPECT_LT((head.centre - centre).norm(), 0.010) << centre.transpose() << ", " << turn;
      EXPECT_LT((head.centre - centre).dot(head.covariance_m2.ldlt().solve(head.centre - centre)), 16.0);
    }
  }
}

// Smaller and larger heads than the mean: the error stays within four of the sigmas that are told.
TEST(Head, TellsHowSureItIs) {
  const Eigen::Vector3d centre(-0.05, 0.03, 0.60);
  for (const double size : {0.92, 1.0, 1.06}) {
    const Head head = found_in({kBody, head_at(centre, 0.2, size)}, 0.010);
    ASSERT_TRUE(head.found) << size;
    const Eigen::Vector3d error = head.centre - centre;
    EXPECT_LT(error.dot(head.covariance_m2.ldlt().solve(error)), 16.0) << size;
    EXPECT_LT(std::sqrt(head.covariance_m2.trace()), 0.030);
  }
}

// Its front is seen whatever its size: 5 mm is what remains of the direction in which the centre is.
TEST(Head, ItsFrontIsSurerThanItsCentre) {
  for (const double size : {0.92, 1.0, 1.06}) {
    const Shape shape = head_at({-0.05, 0.03, 0.60}, 0.2, size);
    const Head head = found_in({kBody, shape}, 0.002);
    ASSERT_TRUE(head.found) << size;
    const Eigen::Vector3d ray = (Eigen::Vector3d(-0.05, 0.03, 0.60) - kEye).normalized();
    const Eigen::Vector3d error = head.front - (kEye + distance_to(shape, ray) * ray);
    EXPECT_LT(error.norm(), 0.005) << size;
    EXPECT_LT(error.dot(head.front_covariance_m2.ldlt().solve(error)), 16.0) << size;
    EXPECT_LT(ray.dot(head.front_covariance_m2 * ray), ray.dot(head.covariance_m2 * ray)) << size;
  }
}

// A fist held before the chest is as round as a head and stands as free; it is lower.
TEST(Head, IsAboveAFist) {
  const Eigen::Vector3d centre(-0.10, 0.0, 0.64);
  const Head head = found_in({kBody, head_at(centre, 0.0), {{0.16, -0.06, 0.45}, {0.09, 0.09, 0.09}}}, 0.002);
  ASSERT_TRUE(head.found);
  EXPECT_LT((head.centre - centre).norm(), 0.010);
  const Head fist = found_in({{{0.16, -0.06, 0.45}, {0.09, 0.09, 0.09}}}, 0.002);
  EXPECT_TRUE(fist.found);  // alone it would be taken for one: that is what the test is about
}

TEST(Head, IsFoundWithoutHeap) {
  const std::vector<ScenePoint> points = seen({kBody, head_at({-0.05, 0.03, 0.60}, 0.2)}, 0.002);
  const Scan scan{.viewpoint_in_vehicle = kEye, .points = points, .rays = 20000};
  const long before = testing::heap_calls;
  const Head head = find_head({}, {}, scan);
  EXPECT_EQ(testing::heap_calls, before);
  EXPECT_TRUE(head.found);
}

TEST(Head, AnEmptySeatHasNone) {
  EXPECT_FALSE(found_in({}, 0.005).found);
  EXPECT_FALSE(find_head({}, {}, {}).found);
}

TEST(Head, AHeadrestIsNone) {
  const Eigen::Vector2d up = SeatPose{}.back_up(), rest = SeatPose{}.bight + 0.72 * up;
  EXPECT_FALSE(found_in({{{rest.x() + 0.02, 0.0, rest.y()}, {0.07, 0.12, 0.09}}}, 0.005).found);
}

// As large and round as a head, but on the cushion; and as high as a head, but too large, or one with the body below.
TEST(Head, ABallOrABagIsNone) {
  EXPECT_FALSE(found_in({{{0.05, 0.0, 0.06}, {0.10, 0.10, 0.10}}}, 0.003).found);
  EXPECT_FALSE(found_in({{{-0.05, 0.0, 0.45}, {0.20, 0.24, 0.35}}}, 0.003).found);
}

// Toddlers' heads are smaller than the prior of adults would have them, and lower: 1 cm as above.
TEST(Head, OfAToddlerIsFoundWhereItIs) {
  const Eigen::Vector3d centre(SeatPose{}.bight.x() + 0.05, 0.0, SeatPose{}.bight.y() + 0.58);
  for (const double turn : {-0.4, 0.0, 0.4}) {
    const Head head = found_in({{{-0.08, 0.0, 0.10}, {0.10, 0.13, 0.20}}, head_at(centre, turn, 0.89)}, 0.004);
    ASSERT_TRUE(head.found) << turn;
    EXPECT_LT((head.centre - centre).norm(), 0.010) << turn;
    EXPECT_LT(head.size, 0.95) << turn;
  }
}

// The wing of a child seat: as wide and high as a head, but flat. It is its bend by which it is told from one.
TEST(Head, AWingIsNone) {
  const Shape wing{{-0.05, 0.03, 0.60}, {0.03, 0.07, 0.10}, std::atan2(0.33, 0.51)};
  EXPECT_FALSE(found_in({wing}, 0.010).found);
  HeadOptions unbent;
  unbent.common_bend_off = INFINITY;
  EXPECT_TRUE(found_in({wing}, 0.010, unbent).found);
}

// One ray in five goes through it: a net, or the rim of something, but no head.
TEST(Head, IsOpaque) {
  const Shape shape = head_at({-0.05, 0.03, 0.60}, 0.2);
  std::vector<ScenePoint> points = seen({kBody, shape}, 0.002);
  std::erase_if(points, [](const ScenePoint& point) { return point.ray % 5 == 0; });
  EXPECT_TRUE(found_among(points).found);
  for (const ScenePoint& point : seen({kBody}, 0.002)) {
    if (point.ray % 5 == 0) points.push_back(point);
  }
  EXPECT_FALSE(found_among(points).found);
}

}  // namespace
}  // namespace raybundle
