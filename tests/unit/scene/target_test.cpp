// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/scene/target.hpp"

#include <gtest/gtest.h>

namespace raybundle {
namespace {

Target target_with_ids(const std::vector<int>& ids) {
  Target target;
  for (const int id : ids) target.points.push_back({id, Eigen::Vector3d(id, 2.0 * id, 0.0)});
  return target;
}

TEST(Target, FindsPointsByIdWithAndWithoutGaps) {
  for (const Target& target : {target_with_ids({0, 1, 2, 3}), target_with_ids({2, 5, 7, 100})}) {
    for (const TargetPoint& point : target.points) EXPECT_EQ(target.find(point.id), &point);
    for (const int id : {-1, 4, 101}) EXPECT_EQ(target.find(id), nullptr);
  }
  EXPECT_EQ(Target{}.find(0), nullptr);
}

TEST(Target, IsFlatWhenNoPointIsRaised) {
  Target target = target_with_ids({0, 1, 2, 3});
  EXPECT_TRUE(target.flat());
  target.points[2].x_in_target.z() = 1e-6;
  EXPECT_FALSE(target.flat());
  for (const Eigen::Vector3d& basis : shape_basis(target)) EXPECT_EQ(basis, Eigen::Vector3d::Zero());
}

// A 3 x 3 board around (2, 3): the corners of the board keep their height under bending, the centre sags fully.
TEST(BoardShape, BasisFollowsItsFormula) {
  Target target;
  for (int id = 0; id < 9; ++id) target.points.push_back({id, Eigen::Vector3d(1 + id % 3, 1 + 2 * (id / 3), 0)});
  const auto basis = shape_basis(target);
  EXPECT_TRUE(basis[4].isApprox(Eigen::Vector3d(1, 1, 0)));
  EXPECT_TRUE(basis[0].isApprox(Eigen::Vector3d(0, 0, 1)));
  EXPECT_TRUE(basis[2].isApprox(Eigen::Vector3d(0, 0, -1)));
  EXPECT_TRUE(basis[8].isApprox(Eigen::Vector3d(0, 0, 1)));
  EXPECT_TRUE(basis[3].isApprox(Eigen::Vector3d(0, 1, 0)));
}

TEST(BoardShape, MovesPointsAlongZOnlyAndLinearly) {
  const Target target = target_with_ids({0, 1, 2, 3});
  const BoardShape shape{0.001, -0.002, 0.003};
  const auto basis = shape_basis(target);
  const auto points = points_on_surface(target, shape);
  for (size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(points[i].head<2>(), target.points[i].x_in_target.head<2>());
    EXPECT_NEAR(points[i].z(), basis[i].dot(Eigen::Vector3d(0.001, -0.002, 0.003)), 1e-18);
  }
}

TEST(BoardShape, APlaneIsTheZeroShape) {
  const Target target = target_with_ids({0, 1, 2, 3});
  const auto points = points_on_surface(target, {});
  for (size_t i = 0; i < points.size(); ++i) EXPECT_EQ(points[i], target.points[i].x_in_target);
}

}  // namespace
}  // namespace raybundle
