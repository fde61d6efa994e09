// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// Real images of chessboards, spoilt: blurred, noisy, small, faint, turned, moved, dark, over-exposed. In every set no
// fewer boards are found than by OpenCV's classic detector, hardly a corner lies elsewhere than in the image as it is,
// and where noise was added corners scatter as their sigmas say. A board counts as found with half of its corners; of
// OpenCV's it has all or none.
#include <Eigen/Core>
#include <cmath>
#include <functional>
#include <map>

#include "raybundle/geometry/quantile.hpp"
#include "raybundle/targets/detect.hpp"
#include "support/bar.hpp"
#include "support/chessboard_images.hpp"

namespace {

using namespace raybundle;
using namespace raybundle::bench;

struct Spoiling {
  const char* name;
  std::function<cv::Mat(const cv::Mat& gray)> spoilt;
  // To where a pixel has gone: homogeneous, from the size of the image.
  std::function<Eigen::Matrix<double, 2, 3>(const cv::Mat& gray)> moved = [](const cv::Mat&) {
    return Eigen::Matrix<double, 2, 3>(Eigen::Matrix<double, 2, 3>::Identity());
  };
  bool only_noise = false;  // grey values changed by noise and rounding alone
  bool beside_opencv = true;
};

cv::Mat with_noise(const cv::Mat& gray, double sigma_grey) {
  cv::Mat noise(gray.size(), CV_32F), noisy;
  cv::RNG random(1);
  random.fill(noise, cv::RNG::NORMAL, 0.0, sigma_grey);
  cv::add(gray, noise, noisy, cv::noArray(), CV_8U);
  return noisy;
}

cv::Mat blurred(const cv::Mat& gray, double sigma_px) {
  cv::Mat out;
  cv::GaussianBlur(gray, out, {0, 0}, sigma_px);
  return out;
}

cv::Mat with_tone(const cv::Mat& gray, const std::function<double(double)>& tone) {
  cv::Mat table(1, 256, CV_8U), out;
  for (int i = 0; i < 256; ++i) table.at<uchar>(i) = cv::saturate_cast<uchar>(tone(i));
  cv::LUT(gray, table, out);
  return out;
}

cv::Mat small(const cv::Mat& gray, int times) {
  cv::Mat out;
  cv::resize(gray, out, {gray.cols / times, gray.rows / times}, 0, 0, cv::INTER_AREA);
  return out;
}

Spoiling shrunk(const char* name, int times) {
  return {name, [times](const cv::Mat& gray) { return small(gray, times); },
          [times](const cv::Mat& gray) {
            const double x = static_cast<double>(gray.cols / times) / gray.cols;
            const double y = static_cast<double>(gray.rows / times) / gray.rows;
            return Eigen::Matrix<double, 2, 3>{{x, 0, 0.5 * x - 0.5}, {0, y, 0.5 * y - 0.5}};
          }};
}

cv::Mat turn_of(const cv::Mat& gray) {
  constexpr double kDegrees = 37.0, kScale = 0.9;
  return cv::getRotationMatrix2D({0.5F * static_cast<float>(gray.cols), 0.5F * static_cast<float>(gray.rows)}, kDegrees,
                                 kScale);
}

std::vector<Spoiling> spoilings() {
  const auto turned = [](const cv::Mat& gray) {
    cv::Mat out;
    cv::warpAffine(gray, out, turn_of(gray), gray.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    return out;
  };
  const auto turn = [](const cv::Mat& gray) {
    const cv::Mat m = turn_of(gray);
    return Eigen::Matrix<double, 2, 3>{{m.at<double>(0, 0), m.at<double>(0, 1), m.at<double>(0, 2)},
                                       {m.at<double>(1, 0), m.at<double>(1, 1), m.at<double>(1, 2)}};
  };
  const auto dragged = [](const cv::Mat& gray) {
    cv::Mat out;
    cv::blur(gray, out, {9, 1});
    return out;
  };
  const auto tone = [](std::function<double(double)> function) {
    return [function](const cv::Mat& gray) { return with_tone(gray, function); };
  };
  return {{"as it is", [](const cv::Mat& gray) { return gray; }},
          {"blurred by 2 px", [](const cv::Mat& gray) { return blurred(gray, 2.0); }},
          {"blurred by 4 px", [](const cv::Mat& gray) { return blurred(gray, 4.0); }},
          {.name = "noise of 12 grey values",
           .spoilt = [](const cv::Mat& gray) { return with_noise(gray, 12.0); },
           .only_noise = true},
          {.name = "noise of 25 grey values",
           .spoilt = [](const cv::Mat& gray) { return with_noise(gray, 25.0); },
           .only_noise = true,
           .beside_opencv = false},  // which takes some ten seconds an image there
          shrunk("half the size", 2),
          shrunk("a third of the size", 3),
          {.name = "a sixth of the contrast",
           .spoilt = tone([](double grey) { return 100.0 + grey / 6.0; }),
           .only_noise = true},
          {"turned by 37 degrees", turned, turn},
          {"dragged over 9 px", dragged},
          {"dark", tone([](double grey) { return 255.0 * std::pow(grey / 255.0, 2.5); })},
          {"over-exposed", tone([](double grey) { return 2.2 * grey; })}};
}

struct Sum {
  std::size_t corners = 0, astray = 0;
  std::vector<double> shifts_px, shifts_sigmas;
};

// How far corners lie from where those of the image as it is have gone. Boards that look alike when they are turned by
// half a turn may be numbered from either end.
void add_shifts(const Detection& before, const Detection& after, const Eigen::Matrix<double, 2, 3>& moved, int corners,
                Sum& sum) {
  std::map<int, Eigen::Vector2d> expected;
  for (const Observation& o : before.observations) expected[o.point_id] = moved * o.pixel.homogeneous();
  std::vector<double> best_px, best_sigmas;
  for (const bool reversed : {false, true}) {
    std::vector<double> px, sigmas;
    for (const Observation& o : after.observations) {
      const auto at = expected.find(reversed ? corners - 1 - o.point_id : o.point_id);
      if (at == expected.end()) continue;
      const Eigen::Vector2d shift = o.pixel - at->second;
      px.push_back(shift.norm());
      for (const double axis : {shift.x(), shift.y()}) sigmas.push_back(std::abs(axis) / o.sigma_px);
    }
    if (best_px.empty() || (!px.empty() && median(px) < median(best_px))) {
      best_px = px;
      best_sigmas = sigmas;
    }
  }
  constexpr double kAstray_px = 2.0;
  sum.corners += best_px.size();
  sum.astray += static_cast<std::size_t>(std::ranges::count_if(best_px, [](double px) { return px > kAstray_px; }));
  sum.shifts_px.insert(sum.shifts_px.end(), best_px.begin(), best_px.end());
  sum.shifts_sigmas.insert(sum.shifts_sigmas.end(), best_sigmas.begin(), best_sigmas.end());
}

}  // namespace

int main() {
  cv::setNumThreads(1);
  constexpr double kMostAstray = 0.003, kMostSigmas = 1.2;
  bool good = true;
  struct Loaded {
    ChessboardSet set;
    std::vector<cv::Mat> images;
    std::vector<Detection> as_they_are;
  };
  std::vector<Loaded> sets;
  for (const ChessboardSet& set : chessboard_sets()) {
    Loaded loaded{set, images_of(set), {}};
    for (const cv::Mat& image : loaded.images) loaded.as_they_are.push_back(detect(set.board, image));
    if (!loaded.images.empty()) sets.push_back(loaded);
  }
  if (sets.empty()) {
    std::printf("no images in %s: set RAYBUNDLE_DATA\n", testing::real_data().c_str());
    return 1;
  }
  std::printf("boards found by raybundle / by OpenCV's findChessboardCorners (0 where it was not asked), of images\n");
  for (const Spoiling& spoiling : spoilings()) {
    std::printf("%-24s", spoiling.name);
    Sum sum;
    bool fewer = false;
    for (const Loaded& loaded : sets) {
      const Chessboard& board = loaded.set.board;
      const int corners = board.columns * board.rows;
      int ours = 0, theirs = 0;
      for (std::size_t i = 0; i < loaded.images.size(); ++i) {
        const cv::Mat image = spoiling.spoilt(loaded.images[i]);
        const Detection found = detect(board, image);
        ours += 2 * static_cast<int>(found.observations.size()) >= corners;
        theirs += spoiling.beside_opencv && !classic_corners(image, board).empty();
        add_shifts(loaded.as_they_are[i], found, spoiling.moved(loaded.images[i]), corners, sum);
      }
      fewer = fewer || ours < theirs;
      std::printf("  %d / %d of %zu", ours, theirs, loaded.images.size());
    }
    std::printf("  %s\n", fewer ? "FAILS" : "ok");
    good &= !fewer;
    const double astray = static_cast<double>(sum.astray) / static_cast<double>(std::max<std::size_t>(1, sum.corners));
    good &= at_most(kMostAstray, "corners astray by more than 2 px", astray, kPercent);
    std::printf("  %-52s %8.3f px\n", "the others' median shift", sum.shifts_px.empty() ? 0.0 : median(sum.shifts_px));
    if (spoiling.only_noise) {
      constexpr double kOneSigma = 0.6827;
      good &= at_most(kMostSigmas, "two thirds of the shifts are less than", quantile(sum.shifts_sigmas, kOneSigma),
                      {"sigmas", 1.0});
    }
  }
  return good ? 0 : 1;
}
