// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <set>

#include "raybundle/targets/board.hpp"

namespace raybundle {
namespace {

std::vector<Board> boards() {
  std::vector<Board> boards;
  for (const char* word :
       {"chessboard:9x6:25mm", "chessboard:8x6:25mm", "chessboard:6x6:25mm", "chessboard:5x5:25mm",
        "charuco:8x7:25mm:19mm:DICT_4X4_100", "aprilgrid:4x3:88mm:0.3", "circles:7x7:20mm", "circles:7x5:20mm",
        "asymmetric_circles:4x11:20mm", "asymmetric_circles:4x8:20mm", "asymmetric_circles:4x10:20mm:row_step=35mm"}) {
    boards.push_back(board_from_word(word));
  }
  return boards;
}

Eigen::Vector3d position(const Board& board, int id) { return target_of(board).find(id)->x_in_target; }

TEST(BoardTarget, IdsFollowTheStatedOrder) {
  EXPECT_EQ(position(Chessboard{9, 6, 0.5}, 2 * 9 + 4), Eigen::Vector3d(2.0, 1.0, 0.0));
  EXPECT_EQ(position(Charuco{9, 6, 0.5, 0.25, "DICT_4X4_100"}, 2 * 8 + 4), Eigen::Vector3d(2.0, 1.0, 0.0));
  EXPECT_EQ(position(Circles{7, 5, 0.5}, 2 * 7 + 4), Eigen::Vector3d(2.0, 1.0, 0.0));
  EXPECT_EQ(position(AsymmetricCircles{4, 11, 0.5}, 2 * 4 + 3), Eigen::Vector3d(3.0, 1.0, 0.0));
  EXPECT_EQ(position(AsymmetricCircles{4, 11, 0.5}, 3 * 4 + 3), Eigen::Vector3d(3.5, 1.5, 0.0));
  // Tag 7 of a grid of 6 columns is the second one of the second row from below; corner 2 is its top-right.
  EXPECT_TRUE(position(AprilGrid{6, 6, 0.5, 0.5}, 4 * 7 + 2).isApprox(Eigen::Vector3d(1.25, 1.25, 0.0)));
}

TEST(BoardTarget, FirstTagDoesNotMoveThePointIds) {
  const AprilGrid plain{4, 3, 0.5, 0.5};
  AprilGrid later = plain;
  later.first_tag = 40;
  EXPECT_EQ(target_of(later).points.front().id, 0);
  EXPECT_EQ(target_of(later).points.size(), target_of(plain).points.size());
}

TEST(BoardTarget, PointsAreSortedAndDoNotRepeat) {
  for (const Board& board : boards()) {
    const Target target = target_of(board);
    EXPECT_TRUE(target.flat());
    for (size_t i = 0; i + 1 < target.points.size(); ++i) EXPECT_LT(target.points[i].id, target.points[i + 1].id);
  }
}

TEST(BoardTarget, SymmetriesArePermutationsButNotTheIdentity) {
  for (const Board& board : boards()) {
    const Target target = target_of(board);
    std::vector<int> ids;
    for (const TargetPoint& point : target.points) ids.push_back(point.id);
    for (const TargetSymmetry& symmetry : target.symmetries) {
      EXPECT_NE(symmetry.ids, ids) << word_of(board);
      EXPECT_TRUE(std::ranges::is_permutation(symmetry.ids, ids)) << word_of(board);
    }
  }
}

// A print is seen from its front only, so that a symmetry is a turn, never a mirror image.
TEST(BoardTarget, SymmetriesAreRotationsInThePlane) {
  for (const Board& board : boards()) {
    const Target target = target_of(board);
    for (const TargetSymmetry& symmetry : target.symmetries) {
      const auto turned = [&](size_t i) { return target.find(symmetry.ids[i])->x_in_target; };
      for (size_t i = 1; i + 1 < target.points.size(); ++i) {
        const Eigen::Vector3d a = target.points[i].x_in_target - target.points[0].x_in_target;
        const Eigen::Vector3d b = target.points[i + 1].x_in_target - target.points[0].x_in_target;
        const Eigen::Vector3d a_turned = turned(i) - turned(0);
        const Eigen::Vector3d b_turned = turned(i + 1) - turned(0);
        EXPECT_NEAR(a.dot(b), a_turned.dot(b_turned), 1e-14) << word_of(board);
        EXPECT_NEAR(a.cross(b).z(), a_turned.cross(b_turned).z(), 1e-14) << word_of(board);
      }
    }
  }
}

TEST(BoardTarget, SymmetriesFormAGroup) {
  for (const Board& board : boards()) {
    const Target target = target_of(board);
    std::set<std::vector<int>> group;
    for (const TargetSymmetry& symmetry : target.symmetries) group.insert(symmetry.ids);
    EXPECT_EQ(group.size(), target.symmetries.size());
    std::vector<int> identity(target.points.size());
    std::iota(identity.begin(), identity.end(), 0);
    group.insert(identity);
    for (const std::vector<int>& first : group) {
      for (const std::vector<int>& second : group) {
        std::vector<int> both;
        for (const int id : first) both.push_back(second[id]);
        EXPECT_TRUE(group.contains(both)) << word_of(board);
      }
    }
  }
}

// Counted by hand on drawn boards: turns, other than the identity, that give the same print.
TEST(BoardTarget, CountsSymmetriesOfThePrint) {
  const auto count = [](const char* word) { return target_of(board_from_word(word)).symmetries.size(); };
  EXPECT_EQ(count("chessboard:9x6:25mm"), 0u);
  EXPECT_EQ(count("chessboard:8x6:25mm"), 1u);
  EXPECT_EQ(count("chessboard:9x7:25mm"), 1u);
  EXPECT_EQ(count("chessboard:6x6:25mm"), 3u);
  EXPECT_EQ(count("chessboard:5x5:25mm"), 1u);  // turned by 90° the corner square changes its colour
  EXPECT_EQ(count("charuco:8x8:25mm:19mm:DICT_4X4_100"), 0u);
  EXPECT_EQ(count("aprilgrid:6x6:88mm:0.3"), 0u);
  EXPECT_EQ(count("circles:7x7:20mm"), 3u);
  EXPECT_EQ(count("circles:7x5:20mm"), 1u);
  EXPECT_EQ(count("asymmetric_circles:4x11:20mm"), 0u);
  EXPECT_EQ(count("asymmetric_circles:4x10:20mm"), 1u);
}

}  // namespace
}  // namespace raybundle
