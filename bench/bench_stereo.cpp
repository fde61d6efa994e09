// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// Stereo matching beside OpenCV's StereoBM and StereoSGBM in one run, on one thread: time of the whole chain, and wrong
// matches at the density that the other has. A match is wrong when it is more than 1 px from all that the truth may be:
// it was rounded to whole pixels of the full-size image. What is more than 1 px from the rounded truth stands beside
// it; there, who is drawn to whole pixels is better off. The columns whose partner may lie outside of the right image
// count for nobody. Steps along paths, census and window were chosen on cones and on aloe halved, plain and disturbed;
// aloe in full size is why coarse levels begin beyond 250 disparities, why the census is wider beyond 128, and why the
// truth's rounding is allowed for.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "raybundle/geometry/quantile.hpp"
#include "raybundle/stereo/stereo.hpp"
#include "real_data.hpp"

namespace {

using namespace raybundle;

struct Scene {
  std::string name;
  cv::Mat left, right, truth_px;  // 0: not known
  int disparities = 0;
  double truth_step_px = 1.0;  // to which the truth is rounded
};

// Time of this thread only: other programs on the machine do not count.
double seconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double median_ms(int runs, const std::function<void()>& work) {
  std::vector<double> times;
  for (int i = 0; i < runs; ++i) {
    const double begin = seconds();
    work();
    times.push_back(1e3 * (seconds() - begin));
  }
  return median(times);
}

GreyView view_of(const cv::Mat& image) {
  return {image.data, image.cols, image.rows, static_cast<std::ptrdiff_t>(image.step[0])};
}

Scene scene_from(const std::string& name, const std::string& left, const std::string& right, const std::string& truth,
                 int disparities) {
  Scene scene{name, cv::imread(left, cv::IMREAD_GRAYSCALE), cv::imread(right, cv::IMREAD_GRAYSCALE), {}, disparities,
              1.0};
  cv::imread(truth, cv::IMREAD_GRAYSCALE).convertTo(scene.truth_px, CV_32F);
  return scene;
}

Scene halved(const Scene& scene) {
  Scene half{scene.name + " halved", {}, {}, {}, scene.disparities / 2, 0.0};
  const cv::Size size(scene.left.cols / 2, scene.left.rows / 2);
  cv::resize(scene.left, half.left, size, 0, 0, cv::INTER_AREA);
  cv::resize(scene.right, half.right, size, 0, 0, cv::INTER_AREA);
  cv::resize(scene.truth_px, half.truth_px, size, 0, 0, cv::INTER_NEAREST);
  half.truth_px *= 0.5;
  half.truth_step_px = 0.5 * scene.truth_step_px;
  return half;
}

// The right camera has another gain and offset, and vignetting.
Scene disturbed(Scene scene) {
  scene.name += " disturbed";
  scene.right = scene.right.clone();
  const double half = 0.5 * scene.right.cols;
  for (int v = 0; v < scene.right.rows; ++v) {
    for (int u = 0; u < scene.right.cols; ++u) {
      const double r2 = (std::pow(u - half, 2) + std::pow(v - 0.5 * scene.right.rows, 2)) / (half * half);
      auto& pixel = scene.right.at<std::uint8_t>(v, u);
      pixel = cv::saturate_cast<std::uint8_t>(pixel * 0.75 * (1 - 0.35 * r2) + 15);
    }
  }
  return scene;
}

struct Score {
  double density = 0.0, wrong = 0.0, off_rounded = 0.0;  // shares
};
Score score_of(const Scene& scene, const cv::Mat& disparity_px) {
  double known = 0, matched = 0, wrong = 0, off_rounded = 0;
  for (int v = 0; v < scene.truth_px.rows; ++v) {
    for (int u = scene.disparities; u < scene.truth_px.cols; ++u) {
      const float truth = scene.truth_px.at<float>(v, u);
      if (!(truth > 0)) continue;
      ++known;
      const float found = disparity_px.at<float>(v, u);
      if (!(found > 0)) continue;
      ++matched;
      off_rounded += std::abs(found - truth) > 1;
      wrong += std::abs(found - truth) > 1 + 0.5 * scene.truth_step_px;
    }
  }
  return {matched / known, wrong / std::max(1.0, matched), off_rounded / std::max(1.0, matched)};
}

Score ours(const Scene& scene, MatchOptions options) {
  options.disparities = scene.disparities;
  Matcher matcher({scene.left.cols, scene.left.rows}, options);
  const DisparityView view = matcher.match(view_of(scene.left), view_of(scene.right));
  return score_of(scene,
                  cv::Mat(scene.left.rows, scene.left.cols, CV_32F, const_cast<float*>(view.disparity_px.pixels)));
}

// Our filters from strict to loose: first the uniqueness goes down from 1 to 0, then the small regions come in, then
// those that both directions agree on to 2 px only.
MatchOptions at_looseness(double looseness, MatchOptions options) {
  options.uniqueness = std::max(0.0, 1.0 - looseness);
  options.least_region_px =
      static_cast<int>(std::lround(options.least_region_px * std::clamp(2.0 - looseness, 0.0, 1.0)));
  if (looseness > 2.0) options.left_right_px = 2;
  return options;
}

// Our wrong matches when the filters are such that as many pixels are matched, or as many as there can be.
Score ours_at_density(const Scene& scene, double density, const MatchOptions& options) {
  double low = 0.0, high = 2.01;
  if (ours(scene, at_looseness(high, options)).density <= density) return ours(scene, at_looseness(high, options));
  for (int i = 0; i < 8; ++i) {
    const double middle = 0.5 * (low + high);
    (ours(scene, at_looseness(middle, options)).density < density ? low : high) = middle;
  }
  return ours(scene, at_looseness(high, options));
}

struct Peer {
  std::string name;
  cv::Ptr<cv::StereoMatcher> matcher;
};
std::vector<Peer> peers(int disparities) {
  const int rounded = (disparities + 15) / 16 * 16;
  constexpr int kSide = 3;  // block and penalties of OpenCV's own example program
  return {{"StereoBM 11x11", cv::StereoBM::create(rounded, 11)},
          {"StereoSGBM", cv::StereoSGBM::create(0, rounded, kSide, 8 * kSide * kSide, 32 * kSide * kSide, 1, 63, 10,
                                                100, 32, cv::StereoSGBM::MODE_SGBM)}};
}

cv::Mat computed(cv::StereoMatcher& matcher, const Scene& scene) {
  cv::Mat fixed, disparity_px;
  matcher.compute(scene.left, scene.right, fixed);
  fixed.convertTo(disparity_px, CV_32F, 1.0 / 16);
  return disparity_px;
}

void print_quality(const std::string& data) {
  const Scene cones =
      scene_from("cones", data + "/cones_left.png", data + "/cones_right.png", data + "/cones_gt.png", 64);
  const Scene aloe =
      scene_from("aloe", data + "/aloe/aloeL.jpg", data + "/aloe/aloeR.jpg", data + "/aloe/aloeGT.png", 224);
  fmt::print("{:<22} {:<14} | {:>7} {:>7} {:>7} | {:>7} {:>7} {:>7} | {}\n", "all in %", "peer", "density", "wrong",
             "rounded", "density", "wrong", "rounded", "ours");
  for (const Scene& plain : {cones, halved(aloe), aloe}) {
    for (const Scene& scene : {plain, disturbed(plain)}) {
      for (const Peer& peer : peers(scene.disparities)) {
        const Score other = score_of(scene, computed(*peer.matcher, scene));
        const auto better = [&](const Score& own) {
          return own.wrong < other.wrong && own.density >= other.density - 0.002;
        };
        MatchOptions options;
        options.mask = census_for(scene.disparities);
        const Score own = ours_at_density(scene, other.density, options);
        fmt::print("{:<22} {:<14} | {:>7.2f} {:>7.2f} {:>7.2f} | {:>7.2f} {:>7.2f} {:>7.2f} | {}", scene.name,
                   peer.name, 100 * other.density, 100 * other.wrong, 100 * other.off_rounded, 100 * own.density,
                   100 * own.wrong, 100 * own.off_rounded, better(own) ? "better" : "NOT better");
        options.coarse_levels = 2;  // as for four times as many disparities
        const Score coarse = ours_at_density(scene, other.density, options);
        fmt::print("; from coarse to fine {:.2f} {:.2f} {:.2f} {}\n", 100 * coarse.density, 100 * coarse.wrong,
                   100 * coarse.off_rounded, better(coarse) ? "better" : "NOT better");
        std::fflush(stdout);
      }
    }
  }
}

// A pair of fisheyes like those of a cabin, rectified as a whole; where they cover nothing, nothing is searched.
Calibration fisheye_pair(ImageSize size) {
  Calibration calibration;
  const Camera camera = start_camera(*model_named("kannala_brandt"), size, 0.36 * size.width);
  calibration.cameras = {{"left", camera, {}}, {"right", camera, {}}};
  calibration.cameras[1].camera_from_rig.translation.x() = -0.12;
  return calibration;
}

// The other costs, numbers of paths, and coarse to fine.
std::vector<MatchOptions> variants(const MatchOptions& base) {
  std::vector<MatchOptions> all(5, base);
  all[0].cost = MatchCost::kSsd;
  all[1].cost = MatchCost::kZncc;
  all[2].paths = 0;
  all[3].paths = 4;
  all[4].coarse_levels = 1;
  return all;
}

void print_times(const std::string& data) {
  const cv::Mat left = cv::imread(data + "/aloe/aloeL.jpg", cv::IMREAD_GRAYSCALE);
  const cv::Mat right = cv::imread(data + "/aloe/aloeR.jpg", cv::IMREAD_GRAYSCALE);
  fmt::print("\n{:<16} {:<40} {:>9} {:>8}\n", "time, one thread", "", "median ms", "bar ms");
  struct Case {
    ImageSize size;
    int disparities;
    double bar_ms;
  };
  for (const Case& one : {Case{{128, 128}, 32, 1.0}, Case{{640, 480}, 64, 12.0}}) {
    Scene scene{fmt::format("{}x{}/{}", one.size.width, one.size.height, one.disparities), {}, {}, {}, one.disparities};
    cv::resize(left, scene.left, {one.size.width, one.size.height}, 0, 0, cv::INTER_AREA);
    cv::resize(right, scene.right, {one.size.width, one.size.height}, 0, 0, cv::INTER_AREA);
    StereoOptions options;
    options.rectify.width_px = one.size.width;
    options.rectify.height_px = one.size.height;
    options.match.disparities = one.disparities;
    StereoMatcher stereo(fisheye_pair(one.size), "left", "right", options);
    Matcher matcher(one.size, options.match);
    const auto row = [&](const std::string& what, const std::string& bar, const std::function<void()>& work) {
      fmt::print("{:<16} {:<40} {:>9.2f} {:>8}\n", scene.name, what, median_ms(31, work), bar);
    };
    const double covered = static_cast<double>(stereo.covered()) / (one.size.width * one.size.height);
    row(fmt::format("ours: whole chain, fisheyes cover {:.0f} %", 100 * covered), fmt::format("{:.0f}", one.bar_ms),
        [&] { stereo.process(view_of(scene.left), view_of(scene.right)); });
    row("ours: match and filter, all covered", "", [&] { matcher.match(view_of(scene.left), view_of(scene.right)); });
    for (MatchOptions variant : variants(options.match)) {
      Matcher other(one.size, variant);
      row(fmt::format("ours: {}, {} paths, {} coarse", match_cost_name(variant.cost), variant.paths,
                      variant.coarse_levels),
          "", [&] { other.match(view_of(scene.left), view_of(scene.right)); });
    }
    for (const Peer& peer : peers(one.disparities))
      row(peer.name + ": match and filter", "", [&] { computed(*peer.matcher, scene); });
  }
}

}  // namespace

int main() {
  cv::setNumThreads(1);
  const std::string data = raybundle::testing::real_data("stereo_gt").string();
  if (cv::imread(data + "/cones_left.png").empty()) {
    fmt::print(stderr, "there is no {}: set RAYBUNDLE_DATA to the folder of real data\n", data);
    return 5;
  }
  print_quality(data);
  print_times(data);
}
