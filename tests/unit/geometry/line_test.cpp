// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/geometry/line.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

namespace raybundle {
namespace {

class LineTest : public ::testing::Test {
 protected:
  Eigen::Vector3d random_direction() {
    return Eigen::Vector3d(normal_(random_), normal_(random_), normal_(random_)).normalized();
  }
  std::mt19937 random_{1};
  std::normal_distribution<double> normal_;
};

TEST_F(LineTest, AcrossIsARightHandedFrameForEveryDirection) {
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d direction = random_direction();
    Eigen::Matrix3d frame;
    frame << across(direction), direction;
    EXPECT_LT((frame.transpose() * frame - Eigen::Matrix3d::Identity()).norm(), 1e-14);
    EXPECT_NEAR(frame.determinant(), 1.0, 1e-14);
  }
}

TEST_F(LineTest, MotionBetweenUndoesPerturbed) {
  for (int i = 0; i < 200; ++i) {
    const Line3 line{random_direction(), random_direction()};
    Eigen::Vector4d motion;
    for (double& component : motion) component = 0.2 * normal_(random_);
    const Line3 moved = perturbed(line, motion);
    EXPECT_LT((motion_between(line, moved) - motion).norm(), 1e-13);
    EXPECT_LT((motion_between(line, {moved.at(0.7), -moved.direction}) - motion).norm(), 1e-13)
        << "a line has no preferred point and no sense";
  }
}

TEST_F(LineTest, LineThroughPointsOnALineIsThatLine) {
  for (int i = 0; i < 50; ++i) {
    const Line3 line{random_direction(), random_direction()};
    Eigen::Matrix3Xd points(3, 5);
    for (int k = 0; k < 5; ++k) points.col(k) = line.at(normal_(random_) + k);
    const Line3 found = line_through(points, {}, line.direction);
    EXPECT_LT(motion_between(line, found).norm(), 1e-12);
    EXPECT_GT(found.direction.dot(line.direction), 0.0);
    EXPECT_LT(distance_between(found, points.col(0)), 1e-12);
  }
}

TEST_F(LineTest, AWeightCountsLikeRepetition) {
  Eigen::Matrix3Xd thrice(3, 6), once(3, 4);
  once << 0, 1, 2, 3, 0, 0.1, -0.1, 0.05, 1, 1.2, 0.9, 1;
  thrice << once, once.col(2), once.col(2);
  const Line3 weighted = line_through(once, Eigen::Array4d(1, 1, 3, 1), Eigen::Vector3d::UnitX());
  EXPECT_LT(motion_between(weighted, line_through(thrice, {}, Eigen::Vector3d::UnitX())).norm(), 1e-13);
}

TEST(Line, ThePointNearestToLinesIsWhereTheyMeet) {
  const Eigen::Vector3d meet(0.1, -0.2, 0.3);
  std::vector<Line3> lines;
  for (const Eigen::Vector3d& towards :
       {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0.3, 0, 1), Eigen::Vector3d(0, 1, 1)}) {
    Line3 line{meet, towards.normalized()};
    line.point = line.at(0.7);
    lines.push_back(line);
  }
  EXPECT_LT((point_nearest_to(lines) - meet).norm(), 1e-8);  // the nudge towards the origin moves it by 1e-9 of itself
  const Line3 alone{{0, 2, 5}, Eigen::Vector3d::UnitZ()};
  EXPECT_LT((point_nearest_to(std::vector{alone}) - Eigen::Vector3d(0, 2, 0)).norm(), 1e-8);
}

}  // namespace
}  // namespace raybundle
