// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Processor time of detecting chessboards in real images: ours beside OpenCV's detectors, each with the flags that its
// documentation recommends, alternating image by image on one thread. Boards found with all corners are `full`, those
// found without some `part`. The images are decoded beforehand: that costs everyone the same.
// usage: bench_detect [images of each set, default all] [repetitions, default 1]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "raybundle/targets/detect.hpp"
#include "support/chessboard_images.hpp"
#include "support/clock.hpp"

namespace {

using namespace raybundle;
using namespace raybundle::bench;

// Other work on the machine must not count: processor time of this thread.
double milliseconds_now() { return 1e3 * seconds(CLOCK_THREAD_CPUTIME_ID); }

struct Detector {
  const char* name;
  std::function<std::size_t(const cv::Mat& gray, const Chessboard& board)> corners;
  std::vector<double> times_ms = {};
  int full = 0, partial = 0;
};

std::size_t classic(const cv::Mat& gray, const Chessboard& board, int flags) {
  return classic_corners(gray, board, flags).size();
}

std::size_t sector_based(const cv::Mat& gray, const Chessboard& board, int flags) {
  std::vector<cv::Point2f> corners;
  return cv::findChessboardCornersSB(gray, {board.columns, board.rows}, corners, flags) ? corners.size() : 0;
}

std::vector<Detector> detectors() {
  using namespace cv;
  const auto of = [](auto* function, int flags) {
    return [=](const Mat& gray, const Chessboard& board) { return function(gray, board, flags); };
  };
  return {
      {"raybundle", [](const Mat& gray, const Chessboard& board) { return detect(board, gray).observations.size(); }},
      {"OpenCV classic + subpix", of(classic, kClassicFlags)},
      {"OpenCV classic, fast check", of(classic, kClassicFlags | CALIB_CB_FAST_CHECK)},
      {"OpenCV SB", of(sector_based, 0)},
      {"OpenCV SB, normalise", of(sector_based, CALIB_CB_NORMALIZE_IMAGE)},
      {"OpenCV SB, exhaustive, accuracy",
       of(sector_based, CALIB_CB_NORMALIZE_IMAGE | CALIB_CB_EXHAUSTIVE | CALIB_CB_ACCURACY)},
      {"OpenCV SB, else classic",  // what a careful user does: more boards than either
       [=](const Mat& gray, const Chessboard& board) {
         const std::size_t found = sector_based(gray, board, CALIB_CB_NORMALIZE_IMAGE);
         return found > 0 ? found : classic(gray, board, kClassicFlags);
       }},
      {"OpenCV classic, else SB",
       [=](const Mat& gray, const Chessboard& board) {
         const std::size_t found = classic(gray, board, kClassicFlags);
         return found > 0 ? found : sector_based(gray, board, CALIB_CB_NORMALIZE_IMAGE);
       }},
  };
}

void run(const ChessboardSet& set, std::size_t most, int repetitions) {
  std::vector<cv::Mat> images = images_of(set);
  if (images.empty()) {
    std::printf("no images in %s: set RAYBUNDLE_DATA\n", testing::real_data(set.folder).c_str());
    return;
  }
  if (images.size() > most) images.resize(most);
  std::vector<Detector> all = detectors();
  const auto whole = static_cast<std::size_t>(set.board.columns * set.board.rows);
  for (const cv::Mat& image : images) {
    for (Detector& detector : all) {
      double best_ms = 1e12;
      std::size_t corners = 0;
      for (int k = 0; k < repetitions; ++k) {
        const double begin = milliseconds_now();
        corners = detector.corners(image, set.board);
        best_ms = std::min(best_ms, milliseconds_now() - begin);
      }
      detector.times_ms.push_back(best_ms);
      detector.full += corners == whole;
      detector.partial += corners >= 4 && corners < whole;
    }
  }
  std::printf("\n%s*: %zu images %dx%d\n", set.folder.c_str(), images.size(), images[0].cols, images[0].rows);
  std::printf("%-34s %6s %6s %10s %9s %9s %12s\n", "detector", "full", "part", "mean ms", "median", "worst", "ratio");
  double ours_ms = 0;
  for (Detector& detector : all) {
    double sum_ms = 0;
    for (const double time : detector.times_ms) sum_ms += time;
    std::ranges::sort(detector.times_ms);
    if (ours_ms == 0) ours_ms = sum_ms;
    std::printf("%-34s %6d %6d %10.2f %9.2f %9.2f %12.2f\n", detector.name, detector.full, detector.partial,
                sum_ms / static_cast<double>(images.size()), detector.times_ms[images.size() / 2],
                detector.times_ms.back(), sum_ms / ours_ms);
  }
  std::fflush(stdout);
}

}  // namespace

int main(int count, char** words) {
  const std::size_t most = count > 1 && std::atoi(words[1]) > 0 ? static_cast<std::size_t>(std::atoi(words[1])) : 1000;
  const int repetitions = count > 2 ? std::max(1, std::atoi(words[2])) : 1;
  cv::setNumThreads(1);
  for (const ChessboardSet& set : chessboard_sets()) run(set, most, repetitions);
  return 0;
}
