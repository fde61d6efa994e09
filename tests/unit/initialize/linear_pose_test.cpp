// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "../../../calib_core/initialize/src/linear_pose.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

namespace raybundle {
namespace {

std::vector<Eigen::Vector3d> board_points() {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 35; ++i) points.emplace_back(0.03 * (i % 7), 0.02 * (i / 7), 0.0);
  return points;
}

TEST(PrincipalFrame, IsTheSameWhereverTheBoardLies) {
  const std::vector<Eigen::Vector3d> board = board_points();
  const PrincipalFrame flat = principal_frame(board);  // in closed form
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, -2, 0.7).normalized()));
  std::vector<Eigen::Vector3d> turned;
  for (const Eigen::Vector3d& point : board) turned.push_back(turn * point + Eigen::Vector3d(0.4, 0, -0.2));
  const PrincipalFrame other = principal_frame(turned);
  EXPECT_TRUE(flat.planar());
  EXPECT_TRUE(other.planar());
  EXPECT_NEAR((flat.spread - other.spread).norm(), 0.0, 1e-8);  // the root of a rounding error
  for (std::size_t i = 0; i < board.size(); ++i) {
    const Eigen::Vector3d a = flat.local(board[i]), b = other.local(turned[i]);
    EXPECT_NEAR((a.cwiseAbs() - b.cwiseAbs()).norm(), 0.0, 1e-8);  // axes up to their signs
  }
  EXPECT_NEAR(flat.local_from_target.determinant(), 1.0, 1e-12);
}

TEST(PrincipalFrame, TellsALineFromABoard) {
  std::vector<Eigen::Vector3d> line;
  for (int i = 0; i < 9; ++i) line.emplace_back(0.01 * i, 0.02 * i, 0.0);
  EXPECT_TRUE(principal_frame(line).collinear());
  line.emplace_back(0.0, 0.05, 0.0);
  EXPECT_FALSE(principal_frame(line).collinear());
  EXPECT_TRUE(principal_frame({}).collinear());
}

}  // namespace
}  // namespace raybundle
