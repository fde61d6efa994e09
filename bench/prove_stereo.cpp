// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// Sub-pixel bars of the stereo runtime on textured planes whose disparity is known exactly: the pixel-locking curve,
// its largest bias (bar 0.05 px) and the largest rms (bar 0.15 px), over textures from fine to coarse. And a small pair
// of fisheyes in simulated cabins with a passenger: points whose disparity is within 1 px of the truth (bar: 3000 of
// 128x128 pixels in every cabin), and the share of points that are not.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <random>
#include <vector>

#include "raybundle/cockpit/cabin_renderer.hpp"
#include "raybundle/stereo/stereo.hpp"

namespace {

using namespace raybundle;

constexpr int kWidth = 200, kHeight = 120;
constexpr double kMostBias_px = 0.05, kMostRms_px = 0.15;

/// White noise blurred by a Gaussian: has a value between pixels, too, without interpolation.
class Texture {
 public:
  Texture(unsigned seed, double blur_px) : blur_px_(blur_px), noise_(kSide * kSide) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    for (double& value : noise_) value = normal(random);
  }

  double grey(double u, double v) const {
    const int reach = static_cast<int>(std::ceil(4 * blur_px_));
    const int column = static_cast<int>(std::floor(u)), row = static_cast<int>(std::floor(v));
    double sum = 0.0;
    for (int j = row - reach; j <= row + reach + 1; ++j) {
      for (int i = column - reach; i <= column + reach + 1; ++i) {
        const double r2 = (u - i) * (u - i) + (v - j) * (v - j);
        sum += noise_[static_cast<std::size_t>((j & (kSide - 1)) * kSide + (i & (kSide - 1)))] *
               std::exp(-r2 / (2 * blur_px_ * blur_px_));
      }
    }
    return 127 + kContrast * sum / (blur_px_ * std::sqrt(M_PI));  // the sum's deviation is blur times √π
  }

 private:
  static constexpr int kSide = 512;
  static constexpr double kContrast = 45.0;  // standard deviation [grey values]
  double blur_px_;
  std::vector<double> noise_;
};

struct Errors {
  double bias_px = 0.0, rms_px = 0.0;
  int matched = 0;
};

// A plane whose disparity is `middle_px` at the middle of the image and grows by `slope` along rows.
Errors errors_of(const Texture& texture, double middle_px, double slope) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, 1.0);
  const auto disparity = [&](int u) { return middle_px + slope * (u - 0.5 * kWidth); };
  std::vector<std::uint8_t> left(kWidth * kHeight), right(kWidth * kHeight);
  const auto grey = [&](double value) {
    return static_cast<std::uint8_t>(std::clamp(std::lround(value + noise(random)), 0L, 255L));
  };
  for (int v = 0, i = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u, ++i) {
      right[static_cast<std::size_t>(i)] = grey(texture.grey(u, v));
      left[static_cast<std::size_t>(i)] = grey(texture.grey(u - disparity(u), v));
    }
  }
  Matcher matcher({kWidth, kHeight}, {.disparities = 32});
  const DisparityView view =
      matcher.match({left.data(), kWidth, kHeight, kWidth}, {right.data(), kWidth, kHeight, kWidth});
  Errors errors;
  double sum = 0.0, sum2 = 0.0;
  for (int v = 10; v < kHeight - 10; ++v) {
    for (int u = 40; u < kWidth - 10; ++u) {
      const double found = view.disparity_px.at(u, v);
      if (!(found > 0)) continue;
      const double error = found - disparity(u);
      sum += error;
      sum2 += error * error;
      ++errors.matched;
    }
  }
  errors.bias_px = sum / std::max(1, errors.matched);
  errors.rms_px = std::sqrt(sum2 / std::max(1, errors.matched));
  return errors;
}

constexpr int kCabins = 10, kLeastValid = 3000;

std::vector<std::uint8_t> bytes_of(const GreyImage& image) {
  std::vector<std::uint8_t> bytes;
  for (const std::uint16_t value : image.values) bytes.push_back(static_cast<std::uint8_t>(value >> (image.bits - 8)));
  return bytes;
}

struct CabinPoints {
  int valid = 0, wrong = 0;
};
CabinPoints points_in_cabin(CockpitGenerator generator, std::uint64_t seed) {
  const CabinSensor sensor = stereo_sensor(generator, seed);
  const Calibration calibration = calibration_of(sensor);
  StereoOptions options;
  options.match.disparities = 32;
  const ImageSize size = calibration.cameras[0].camera.size;
  options.rectify.width_px = size.width;
  options.rectify.height_px = size.height;
  StereoMatcher matcher(calibration, calibration.cameras[0].name, calibration.cameras[1].name, options);
  const CabinScene scene(make_cockpit({.generator = generator, .seed = seed, .wanted = CabinClass::kPassenger}));
  const CabinRenderer renderer(sensor);
  const std::vector<std::uint8_t> left = bytes_of(renderer.image(scene, 0, {.seed = seed}));
  const std::vector<std::uint8_t> right = bytes_of(renderer.image(scene, 1, {.seed = seed}));
  const StereoFrame frame = matcher.process({left.data(), size.width, size.height, size.width},
                                            {right.data(), size.width, size.height, size.width});
  const Rectification& pair = matcher.rectification();
  const Rigid3 vehicle_from_rectified = sensor.vehicle_from_rig * pair.rig_from_rectified;
  const bool pinhole = pair.camera.projection == RectifiedProjection::kPinhole;
  CabinPoints points;
  for (int v = 0; v < frame.points.height; ++v) {
    for (int u = 0; u < frame.points.width; ++u) {
      if (frame.points.at(u, v).sigma_m == 0) continue;
      const auto ray = pair.camera.ray_from_pixel({u, v});
      const auto hit = scene.first_hit(vehicle_from_rectified.translation, vehicle_from_rectified.rotation * *ray);
      const double distance = hit ? hit->distance_m * (pinhole ? ray->z() : 1.0) : 1e9;
      const double truth_px = disparity_from_distance(pair.camera, pair.baseline_m, u, distance);
      const bool right_one = std::abs(frame.disparity.disparity_px.at(u, v) - truth_px) <= 1;
      ++(right_one ? points.valid : points.wrong);
    }
  }
  return points;
}

bool cabins_hold() {
  int least = 128 * 128;
  for (const CockpitGenerator generator : {CockpitGenerator::kTraining, CockpitGenerator::kTest}) {
    std::printf("%s cabins, valid points (wrong %%):", generator == CockpitGenerator::kTraining ? "training" : "test");
    for (std::uint64_t seed = 1; seed <= kCabins; ++seed) {
      const CabinPoints points = points_in_cabin(generator, seed);
      std::printf(" %d (%.1f)", points.valid, 100.0 * points.wrong / std::max(1, points.valid + points.wrong));
      least = std::min(least, points.valid);
    }
    std::printf("\n");
  }
  std::printf("fewest valid points in a cabin: %d (bar %d): %s\n", least, kLeastValid,
              least >= kLeastValid ? "holds" : "DOES NOT HOLD");
  return least >= kLeastValid;
}

}  // namespace

int main() {
  double worst_bias = 0.0, worst_rms = 0.0;
  int least_matched = kWidth * kHeight;
  for (const double blur_px : {0.7, 1.0, 1.5}) {
    const Texture texture(1, blur_px);
    std::printf("texture blurred by %.1f px\n  fraction px   bias px   rms px   matched\n", blur_px);
    const auto show = [&](const char* what, double fraction, double slope) {
      const Errors errors = errors_of(texture, 12 + fraction, slope);
      std::printf("  %-6s %4.1f   %+7.3f  %7.3f   %7d\n", what, fraction, errors.bias_px, errors.rms_px,
                  errors.matched);
      worst_bias = std::max(worst_bias, std::abs(errors.bias_px));
      worst_rms = std::max(worst_rms, errors.rms_px);
      least_matched = std::min(least_matched, errors.matched);
    };
    for (int tenth = 0; tenth < 10; ++tenth) show("flat", 0.1 * tenth, 0.0);
    show("slant", 0.0, 0.03);
  }
  const bool holds = worst_bias <= kMostBias_px && worst_rms <= kMostRms_px && least_matched > kWidth * kHeight / 2;
  std::printf("largest bias %.3f px (bar %.2f), largest rms %.3f px (bar %.2f): %s\n", worst_bias, kMostBias_px,
              worst_rms, kMostRms_px, holds ? "holds" : "DOES NOT HOLD");
  return cabins_hold() && holds ? 0 : 1;
}
