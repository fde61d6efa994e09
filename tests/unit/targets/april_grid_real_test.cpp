// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "raybundle/targets/detect.hpp"
#include "real_images.hpp"

namespace raybundle {
namespace {

constexpr const char* kFolder = "aprilgrid_rs/tests_data";

// Tags with at least three of their corners.
std::size_t whole_tags(const std::vector<Observation>& corners) {
  std::map<int, int> count;
  for (const Observation& corner : corners) ++count[corner.point_id / 4];
  return static_cast<std::size_t>(std::ranges::count_if(count, [](const auto& tag) { return tag.second >= 3; }));
}

TEST(RealAprilGrid, HasAllTagsThatCanBeSeen) {
  RAYBUNDLE_NEEDS_IMAGES(testing::real_images(kFolder), kFolder);
  const std::map<std::string, AprilGrid> boards{{"TUM_VI", {6, 6, 0.088, 0.3}}, {"r45", {6, 6, 0.088, 0.3}},
                                                {"EuRoC", {6, 6, 0.088, 0.3}},  {"top", {6, 6, 0.088, 0.3}},
                                                {"right", {6, 6, 0.088, 0.3}},  {"top_right", {6, 6, 0.088, 0.3}},
                                                {"iphone", {11, 6, 0.088, 0.3}}};
  for (const auto& [name, board] : boards) {
    const cv::Mat image = testing::grey_image(testing::real_data() / kFolder / (name + ".png"));
    const Detection detection = detect(board, image);
    // In "top" the last row lies in the lens's dark rim.
    const double share = name == "top" ? 0.88 : 0.99;
    EXPECT_GE(static_cast<double>(whole_tags(detection.observations)), share * board.columns * board.rows) << name;
    EXPECT_GE(static_cast<double>(detection.observations.size()), share * 4 * board.columns * board.rows) << name;
  }
}

TEST(RealAprilGrid, IsToldFromAnotherBoardByItsFirstTag) {
  RAYBUNDLE_NEEDS_IMAGES(testing::real_images(kFolder), kFolder);
  const cv::Mat image = testing::grey_image(testing::real_data() / kFolder / "two_boards.png");
  AprilGrid board{6, 6, 0.088, 0.3};
  const Detection first = detect(board, image);
  board.first_tag = 36;
  const Detection second = detect(board, image);
  EXPECT_EQ(whole_tags(first.observations) + whole_tags(second.observations), 72u);
  EXPECT_GT((first.observations[0].pixel - second.observations[0].pixel).norm(), 300.0) << "they stand side by side";
}

TEST(RealAprilGrid, OfAMirroredImageNamesTheMirror) {
  RAYBUNDLE_NEEDS_IMAGES(testing::real_images(kFolder), kFolder);
  cv::Mat mirrored;
  cv::flip(testing::grey_image(testing::real_data() / kFolder / "TUM_VI.png"), mirrored, 1);
  const Detection detection = detect(AprilGrid{6, 6, 0.088, 0.3}, mirrored);
  EXPECT_TRUE(detection.observations.empty());
  EXPECT_NE(detection.hint.find("the images are mirrored"), std::string::npos) << detection.hint;
}

TEST(RealAprilGrid, OfAnotherBorderNamesIt) {
  RAYBUNDLE_NEEDS_IMAGES(testing::real_images(kFolder), kFolder);
  const cv::Mat image = testing::grey_image(testing::real_data() / kFolder / "TUM_VI.png");
  AprilGrid board{6, 6, 0.088, 0.3};
  board.border_bits = 1;
  const Detection detection = detect(board, image);
  EXPECT_TRUE(detection.observations.empty());
  EXPECT_NE(detection.hint.find("try :2bit (in TOML border_bits = 2)"), std::string::npos) << detection.hint;
}

// All is grey but for a rectangle around some tags.
cv::Mat with_tags_only(const cv::Mat& image, const std::vector<Observation>& corners, const std::set<int>& tags) {
  constexpr double kMargin_px = 6.0;
  Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);
  for (const Observation& corner : corners) {
    if (!tags.contains(corner.point_id / 4)) continue;
    low = low.cwiseMin(corner.pixel);
    high = high.cwiseMax(corner.pixel);
  }
  cv::Mat masked(image.size(), CV_8U, cv::Scalar(128));
  const cv::Rect kept(static_cast<int>(low.x() - kMargin_px), static_cast<int>(low.y() - kMargin_px),
                      static_cast<int>(high.x() - low.x() + 2 * kMargin_px),
                      static_cast<int>(high.y() - low.y() + 2 * kMargin_px));
  image(kept).copyTo(masked(kept));
  return masked;
}

// Codes are printed turned by any number of quarters, which a lone tag does not show: it was numbered from the wrong
// corner.
TEST(RealAprilGrid, TwoTagsAreNumberedAsAllAreAndOneIsNot) {
  RAYBUNDLE_NEEDS_IMAGES(testing::real_images(kFolder), kFolder);
  const AprilGrid board{6, 6, 0.088, 0.3};
  const cv::Mat image = testing::grey_image(testing::real_data() / kFolder / "EuRoC.png");
  const std::vector<Observation> all = detect(board, image).observations;
  const Detection one = detect(board, with_tags_only(image, all, {14}));
  EXPECT_TRUE(one.observations.empty());
  EXPECT_NE(one.hint.find("only one tag"), std::string::npos) << one.hint;
  const Detection two = detect(board, with_tags_only(image, all, {14, 15}));
  ASSERT_GE(two.observations.size(), 6U);
  for (const Observation& corner : two.observations) {
    const auto same = std::ranges::find(all, corner.point_id, &Observation::point_id);
    ASSERT_NE(same, all.end());
    EXPECT_LT((same->pixel - corner.pixel).norm(), 1.0) << corner.point_id;
  }
}

}  // namespace
}  // namespace raybundle
