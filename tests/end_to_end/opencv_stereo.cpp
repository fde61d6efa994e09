// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "opencv_stereo.hpp"

#include <fmt/format.h>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace raybundle::testing {
namespace {

constexpr int kColumns = 9, kRows = 6;

std::vector<cv::Point2f> corners_in(const cv::Mat& image) {
  std::vector<cv::Point2f> corners;
  if (!cv::findChessboardCorners(image, {kColumns, kRows}, corners)) return {};
  // The smallest squares are 17 px wide: a window of 11 px does not reach the next corner.
  const cv::TermCriteria until(cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 100, 1e-4);
  cv::cornerSubPix(image, corners, {5, 5}, {-1, -1}, until);
  return corners;
}

}  // namespace

double opencv_baseline_in_squares(const std::filesystem::path& folder) {
  std::vector<cv::Point3f> board;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      board.emplace_back(static_cast<float>(column), static_cast<float>(row), 0.0F);
    }
  }
  std::vector<std::vector<cv::Point2f>> corners[2];
  cv::Size size;
  for (int pair = 1; pair <= 14; ++pair) {
    std::vector<cv::Point2f> found[2];
    const char* names[] = {"left", "right"};
    for (int side = 0; side < 2; ++side) {
      const auto file = folder / fmt::format("{}{:02}.jpg", names[side], pair);
      const cv::Mat image = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
      if (image.empty()) continue;
      size = image.size();
      found[side] = corners_in(image);
    }
    if (found[0].empty() || found[1].empty()) continue;
    for (int side = 0; side < 2; ++side) corners[side].push_back(found[side]);
  }
  const std::vector<std::vector<cv::Point3f>> boards(corners[0].size(), board);
  cv::Mat camera[2], distortion[2], rotation, translation, essential, fundamental;
  std::vector<cv::Mat> rotations, translations;
  for (int side = 0; side < 2; ++side) {
    cv::calibrateCamera(boards, corners[side], size, camera[side], distortion[side], rotations, translations);
  }
  cv::stereoCalibrate(boards, corners[0], corners[1], camera[0], distortion[0], camera[1], distortion[1], size,
                      rotation, translation, essential, fundamental, cv::CALIB_USE_INTRINSIC_GUESS,
                      {cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 200, 1e-9});
  return cv::norm(translation);
}

}  // namespace raybundle::testing
