// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/targets/detect.hpp"

#include <opencv2/core.hpp>
#include <variant>

#include "april_grid.hpp"
#include "charuco.hpp"
#include "chessboard.hpp"
#include "circles.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

struct Detect {
  const cv::Mat& gray;

  Detection operator()(const Chessboard& board) const { return detect_chessboard(gray, board); }
  Detection operator()(const Charuco& board) const { return detect_charuco(gray, board); }
  Detection operator()(const AprilGrid& board) const { return detect_april_grid(gray, board); }
  Detection operator()(const Circles& board) const { return detect_circles(gray, board); }
  Detection operator()(const AsymmetricCircles& board) const { return detect_circles(gray, board); }
  Detection operator()(const PointSet& board) const {
    throw Error(ErrorKind::kBadInput, "a list of points cannot be found in images: give its observations in a file",
                board.file);
  }
};

struct Refine {
  const cv::Mat& gray;
  const std::vector<Observation>& predicted;

  std::vector<Observation> operator()(const Chessboard& board) const {
    return refine_predicted_chessboard(gray, board, predicted);
  }
  std::vector<Observation> operator()(const Charuco& board) const {
    return refine_predicted_charuco(gray, board, predicted);
  }
  std::vector<Observation> operator()(const AprilGrid& board) const {
    return refine_predicted_april_grid(gray, board, predicted);
  }
  std::vector<Observation> operator()(const Circles& board) const {
    return refine_predicted_circles(gray, board, predicted);
  }
  std::vector<Observation> operator()(const AsymmetricCircles& board) const {
    return refine_predicted_circles(gray, board, predicted);
  }
  std::vector<Observation> operator()(const PointSet&) const { return {}; }
};

// The detectors read 8 bits; of 16 the range that the image fills is kept.
cv::Mat detector_image(const cv::Mat& gray) {
  if (gray.empty() || gray.channels() != 1 || (gray.depth() != CV_8U && gray.depth() != CV_16U)) {
    throw Error(ErrorKind::kBadInput,
                "boards are looked for in 8-bit or 16-bit images of one channel: convert to grey");
  }
  if (gray.depth() == CV_8U) return gray;
  double low = 0.0;
  double high = 0.0;
  cv::minMaxLoc(gray, &low, &high);
  cv::Mat scaled;
  const double scale = high > low ? 255.0 / (high - low) : 1.0;
  gray.convertTo(scaled, CV_8U, scale, -low * scale);
  return scaled;
}

}  // namespace

Detection detect(const Board& board, const cv::Mat& gray) {
  const cv::Mat image = detector_image(gray);
  return std::visit(Detect{image}, board);
}

std::vector<Observation> refine_predicted(const Board& board, const cv::Mat& gray,
                                          const std::vector<Observation>& predicted) {
  const cv::Mat image = detector_image(gray);
  return std::visit(Refine{image, predicted}, board);
}

}  // namespace raybundle
