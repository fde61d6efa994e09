// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "cabin_scene.hpp"
#include "raybundle/device/image_view.hpp"

namespace raybundle::testing {

/// What lies in an image beside the dots; grey values.
struct LightOptions {
  double ambient = 25.0;
  double sun = 0.0;      ///< of a patch with sharp edges across the image
  double texture = 0.0;  ///< amplitude of a smooth texture
  double read_noise = 0.2;
  double grey_per_electron = 0.0255;  ///< a full well of 10,000 electrons
  double spot_peak = 70.0;            ///< of a dot one metre away
  double blur_px = 0.55;
  double spot_radius_m = 2e-3;  ///< 1/e² of a beam
};

/// An image of dots as Gaussian spots, wider where they are near, and of what else is lit.
class SpotImage {
 public:
  SpotImage(ImageSize size, const std::vector<SceneDot>& dots, bool laser_on, const LightOptions& light, Random& random)
      : size_(size), grey_(static_cast<std::size_t>(size.width) * size.height) {
    std::vector<double> lit(grey_.size());
    for (int v = 0; v < size.height; ++v) {
      for (int u = 0; u < size.width; ++u) {
        // The rim of the patch is as sharp as the lens makes it.
        const auto beyond = [&](double px) { return 0.5 * (1.0 + std::erf(px / (light.blur_px * M_SQRT2))); };
        const double sunny = beyond(u - 0.45 * size.width) * beyond(0.8 * size.width - u) *
                             beyond((v - 0.3 * u) / 1.044) * beyond((0.3 * u + 120 - v) / 1.044);
        lit[index(u, v)] = light.ambient * (1.0 + 0.3 * std::sin(0.004 * u)) + sunny * light.sun +
                           light.texture * (1.0 + std::sin(0.11 * u + 0.07 * v));
      }
    }
    for (std::size_t i = 0; laser_on && i < dots.size(); ++i) paint(dots[i], light, lit);
    for (std::size_t i = 0; i < lit.size(); ++i) {
      const double sigma = std::sqrt(light.read_noise * light.read_noise + light.grey_per_electron * lit[i]);
      grey_[i] = static_cast<std::uint8_t>(std::clamp(lit[i] + sigma * random.normal() + 0.5, 0.0, 255.0));
    }
  }

  GreyView view() const { return {grey_.data(), size_.width, size_.height, size_.width}; }

 private:
  std::size_t index(int u, int v) const { return static_cast<std::size_t>(v) * size_.width + u; }

  // The light of the spot over each pixel's square, of a beam of the same power everywhere.
  void paint(const SceneDot& dot, const LightOptions& light, std::vector<double>& lit) const {
    const double distance = dot.x_in_camera.norm() > 0.0 ? dot.x_in_camera.norm() : 0.7;
    const double of_beam = 0.5 * light.spot_radius_m / distance * 282.0;
    const double sigma = std::hypot(of_beam, light.blur_px);
    const double flux = light.spot_peak * 2.0 * M_PI * (0.55 * 0.55 + 0.28 * 0.28) / (distance * distance);
    const int reach = static_cast<int>(std::ceil(5.0 * sigma));
    const int u0 = static_cast<int>(dot.dot.pixel.x()), v0 = static_cast<int>(dot.dot.pixel.y());
    const auto share = [sigma](double d) {
      return 0.5 * (std::erf((d + 0.5) / (sigma * M_SQRT2)) - std::erf((d - 0.5) / (sigma * M_SQRT2)));
    };
    for (int v = std::max(0, v0 - reach); v <= std::min(size_.height - 1, v0 + reach); ++v) {
      for (int u = std::max(0, u0 - reach); u <= std::min(size_.width - 1, u0 + reach); ++u) {
        lit[index(u, v)] += flux * share(u - dot.dot.pixel.x()) * share(v - dot.dot.pixel.y());
      }
    }
  }

  ImageSize size_;
  std::vector<std::uint8_t> grey_;
};

}  // namespace raybundle::testing
