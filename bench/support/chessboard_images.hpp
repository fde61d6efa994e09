// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "raybundle/targets/board.hpp"
#include "real_images.hpp"

namespace raybundle::bench {

/// Images of one printed chessboard, as others took them.
struct ChessboardSet {
  std::string folder, prefix;  ///< of the files
  Chessboard board;
};

inline std::vector<ChessboardSet> chessboard_sets() {
  return {{"sourishg_fisheye_stereo/imgs", "", {9, 6, 0.02423}},
          {"camodocal_fisheye/images", "img", {9, 6, 0.12}},
          {"ocam/Fisheye1", "Fisheye1", {8, 6, 0.0325}},
          {"opencv_stereo_chess", "left0", {9, 6, 0.025}},
          {"boofcv_stereo/Bumblebee2_Chess", "left", {6, 4, 0.03}}};
}

/// Grey images in the order of their names; none when the folder is not there.
inline std::vector<cv::Mat> images_of(const ChessboardSet& set) {
  std::vector<cv::Mat> images;
  for (const auto& file : testing::real_images(set.folder, set.prefix)) images.push_back(testing::grey_image(file));
  return images;
}

/// What OpenCV's documentation recommends for its classic detector.
inline constexpr int kClassicFlags = cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE;

/// All corners of the board, or none.
inline std::vector<cv::Point2f> classic_corners(const cv::Mat& gray, const Chessboard& board,
                                                int flags = kClassicFlags) {
  std::vector<cv::Point2f> corners;
  if (!cv::findChessboardCorners(gray, {board.columns, board.rows}, corners, flags)) return {};
  // Half the shortest distance to a neighbour, so that no window holds two corners.
  double shortest_px = 1e9;
  for (std::size_t i = 1; i < corners.size(); ++i) {
    if (i % static_cast<std::size_t>(board.columns) != 0)
      shortest_px = std::min(shortest_px, cv::norm(corners[i] - corners[i - 1]));
  }
  const int half = std::clamp(static_cast<int>(shortest_px / 2), 2, 11);
  cv::cornerSubPix(gray, corners, {half, half}, {-1, -1}, {cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 30, 0.01});
  return corners;
}

}  // namespace raybundle::bench
