// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <opencv2/aruco.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "raybundle/targets/board_picture.hpp"
#include "raybundle/targets/detect.hpp"
#include "raybundle/targets/draw.hpp"

namespace raybundle {
namespace {

constexpr int kSquare_px = 60;

cv::Mat screen_image(const Board& board) {
  DrawOptions options;
  options.square_px = kSquare_px;
  const std::string bytes = draw(board, DrawingFormat::kPng, options).bytes;
  return cv::imdecode(std::vector<unsigned char>(bytes.begin(), bytes.end()), cv::IMREAD_GRAYSCALE);
}

// Pixel of each point of a board on its screen image: the margin is one square, and pixel 0 is centred at half a pixel.
Eigen::Vector2d pixel_on_screen(const Board& board, const Target& target, int id, double square_m) {
  const Eigen::Vector2d in_picture = picture_of(board).picture_from_target(target.find(id)->x_in_target);
  return (in_picture / square_m + Eigen::Vector2d::Ones()) * kSquare_px - Eigen::Vector2d::Constant(0.5);
}

struct Case {
  const char* word;
  double square_m;
};

void PrintTo(const Case& tested, std::ostream* out) { *out << tested.word; }

class DrawnBoard : public testing::TestWithParam<Case> {};

// The law that ties drawing, target_of and detection together: every point is found where it was drawn, under its id.
// A slight blur stands for a lens; the tolerance is what a detector may miss on sharp synthetic edges.
TEST_P(DrawnBoard, IsDetectedWithTheIdsItWasDrawnWith) {
  const Board board = board_from_word(GetParam().word);
  const Target target = target_of(board);
  cv::Mat image = screen_image(board);
  cv::GaussianBlur(image, image, {}, 1.0);
  const Detection detection = detect(board, image);
  ASSERT_EQ(detection.observations.size(), target.points.size()) << detection.hint;

  // Symmetric boards may be labelled in any of their ways; all points in the same one.
  std::vector<std::vector<int>> labellings{{}};
  for (const TargetPoint& point : target.points) labellings[0].push_back(point.id);
  for (const TargetSymmetry& symmetry : target.symmetries) labellings.push_back(symmetry.ids);
  double best = 1e9;
  for (const std::vector<int>& ids : labellings) {
    double worst = 0.0;
    for (size_t i = 0; i < target.points.size(); ++i) {
      const Eigen::Vector2d drawn = pixel_on_screen(board, target, ids[i], GetParam().square_m);
      worst = std::max(worst, (detection.observations[i].pixel - drawn).norm());
    }
    best = std::min(best, worst);
  }
  EXPECT_LT(best, 0.15) << "[px]";
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, DrawnBoard,
    testing::Values(Case{"chessboard:9x6:25mm", 0.025}, Case{"chessboard:8x6:25mm", 0.025},
                    Case{"asymmetric_circles:4x11:15mm:row_step=20mm", 0.015},
                    Case{"charuco:8x8:20mm:15mm:DICT_4X4_1000", 0.020},
                    Case{"charuco:8x8:20mm:15mm:DICT_4X4_1000:legacy", 0.020},
                    Case{"charuco:5x4:20mm:15mm:DICT_4X4_1000:inverted", 0.020},
                    Case{"charuco:6x9:20mm:15mm:DICT_6X6_250", 0.020}, Case{"aprilgrid:5x4:88mm:0.3", 0.088},
                    Case{"aprilgrid:5x4:88mm:0.3:1bit", 0.088}, Case{"aprilgrid:3x4:88mm:0.3:25h9:1bit", 0.088},
                    Case{"aprilgrid:2x2:88mm:0.3:first_tag=100", 0.088}, Case{"aprilgrid:5x4:88mm:0.3:top_down", 0.088},
                    Case{"aprilgrid:4x3:88mm:0.3:DICT_5X5_250:1bit:first_tag=20:top_down", 0.088},
                    Case{"circles:7x7:20mm", 0.020}, Case{"circles:7x5:20mm", 0.020},
                    Case{"asymmetric_circles:4x11:20mm", 0.020}));

// Tag 0 of tag36h11 has the published code 0xd5d628584, most significant bit at the top-left: what Kalibr prints.
TEST(DrawnAprilGrid, HasThePublishedCodeUpright) {
  const Board board = board_from_word("aprilgrid:1x1:80mm:0.25");  // 10 cells of 6 px
  const cv::Mat image = screen_image(board);
  constexpr int kCell = kSquare_px / 10;
  const int code_at = kSquare_px + kSquare_px / 4 + 2 * kCell;  // margin, gap, border
  std::uint64_t code = 0;
  for (int bit = 0; bit < 36; ++bit) {
    const int row = code_at + (bit / 6) * kCell + kCell / 2;
    const int column = code_at + (bit % 6) * kCell + kCell / 2;
    code = 2 * code + (image.at<unsigned char>(row, column) > 127 ? 1 : 0);
  }
  EXPECT_EQ(code, 0xd5d628584u);
}

// OpenCV's own print is the oracle: its ids, its corners, wherever they come to lie between pixels.
TEST(OpenCvGridBoard, IsAGridThatCountsTopDown) {
  constexpr int kScale = 8;  // of the print, so that it can be moved by parts of a pixel
  constexpr int kTag = 60 * kScale, kGap = 15 * kScale, kMargin = 40 * kScale;
  constexpr int kColumns = 4, kRows = 3;
  const auto dictionary = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_50);
  const auto print = cv::aruco::GridBoard::create(kColumns, kRows, kTag, kGap, dictionary);
  const cv::Size size(kColumns * (kTag + kGap) - kGap + 2 * kMargin, kRows * (kTag + kGap) - kGap + 2 * kMargin);
  cv::Mat drawn;
  print->draw(size, drawn, kMargin, 1);
  const std::string grid = "aprilgrid:4x3:60mm:0.25:DICT_4X4_50:1bit";
  for (int moved = 0; moved < kScale; ++moved) {
    cv::Mat image;
    const cv::Rect seen_part(moved, moved / 2, size.width - kScale, size.height - kScale);
    cv::resize(drawn(seen_part), image, {}, 1.0 / kScale, 1.0 / kScale, cv::INTER_AREA);
    cv::GaussianBlur(image, image, {}, 1.0);
    const Detection detection = detect(board_from_word(grid + ":top_down"), image);
    ASSERT_EQ(detection.observations.size(), 4u * kColumns * kRows) << detection.hint;
    for (const Observation& seen : detection.observations) {
      // Ours run anticlockwise from the bottom left; OpenCV's clockwise from the top left, y up or down by version.
      const cv::Point3f corner = print->objPoints[seen.point_id / 4][3 - seen.point_id % 4];
      const double right = corner.x, below_top = std::abs(corner.y - print->objPoints[0][0].y);
      const Eigen::Vector2d in_part(kMargin + right - seen_part.x, kMargin + below_top - seen_part.y);
      const Eigen::Vector2d there = in_part / kScale - Eigen::Vector2d::Constant(0.5);
      EXPECT_LT((seen.pixel - there).norm(), 0.05) << seen.point_id << " moved by " << moved;
    }
    EXPECT_THAT(detect(board_from_word(grid), image).hint, testing::HasSubstr("try :top_down"));
  }
}

}  // namespace
}  // namespace raybundle
