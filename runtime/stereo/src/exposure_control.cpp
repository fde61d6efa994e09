// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/stereo/exposure_control.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "require.hpp"

namespace raybundle {
namespace {

constexpr double kLargestFactor = 8.0;     // of a change, when an image says little but too dark or too bright
constexpr double kBrightPartFactor = 2.0;  // when the median is good and a part of the areas is saturated
constexpr double kLeastSignal_grey = 1.0;  // what rounding to whole grey values leaves of a signal

const SensorLimits& checked(const SensorLimits& limits) {
  require(limits.least_shutter_s > 0 && limits.least_shutter_s <= limits.most_shutter_s,
          "a sensor's shutter is positive, the shortest at most the longest");
  require(limits.least_gain > 0 && limits.least_gain <= limits.most_gain,
          "a sensor's gain is positive, the least at most the largest");
  require(limits.shutter_step_s >= 0 && limits.gain_step >= 0, "a sensor's steps of shutter and gain are not negative");
  require(limits.black_grey >= 0 && limits.black_grey < limits.saturated_grey && limits.saturated_grey <= 255,
          "a sensor's grey values are from 0 to 255, black below saturated");
  return limits;
}

const ExposureOptions& checked(const ExposureOptions& options, const SensorLimits& limits) {
  require(options.target_grey > limits.black_grey + kLeastSignal_grey && options.target_grey < options.bright_grey &&
              options.bright_grey < limits.saturated_grey,
          "the grey values of an exposure grow from the sensor's black over target and bright to saturated");
  require(options.bright_share > 0 && options.bright_share < 0.5, "the bright share is between 0 and 0.5");
  require(options.hold >= 0 && options.hold < 0.5, "the error to be held is from 0 to 0.5");
  return options;
}

std::vector<ExposureArea> checked(std::vector<ExposureArea> areas, ImageSize size) {
  require(size.width > 0 && size.height > 0, "an image to be exposed has pixels");
  if (areas.empty()) areas.push_back({0, 0, size.width, size.height, 1.0});
  double sum = 0.0;
  for (const ExposureArea& area : areas) {
    require(area.width_px > 0 && area.height_px > 0 && area.x_px >= 0 && area.y_px >= 0 &&
                area.width_px <= size.width - area.x_px && area.height_px <= size.height - area.y_px,
            "an area to be exposed has pixels, all of them in the image");
    require(area.weight >= 0 && std::isfinite(area.weight), "the weight of an area to be exposed is not negative");
    sum += area.weight;
  }
  require(sum > 0, "at least one area to be exposed has a weight");
  for (ExposureArea& area : areas) area.weight /= sum;
  return areas;
}

// The steps from `least` to a value, which are whole numbers up to rounding.
double steps_to(double value, double least, double step) { return (value - least) / step + 1e-9; }

using Shares = std::array<double, 256>;  // of the areas, for each grey value

Shares grey_shares(GreyView image, const std::vector<ExposureArea>& areas) {
  Shares shares{};
  for (const ExposureArea& area : areas) {
    std::array<int, 256> counts{};
    for (int v = area.y_px; v < area.y_px + area.height_px; ++v) {
      const std::uint8_t* row = image.row(v) + area.x_px;
      for (int u = 0; u < area.width_px; ++u) ++counts[row[u]];
    }
    const double share_of_pixel = area.weight / (static_cast<double>(area.width_px) * area.height_px);
    for (std::size_t grey = 0; grey < counts.size(); ++grey) shares[grey] += share_of_pixel * counts[grey];
  }
  return shares;
}

// Grey value that a share of the areas does not exceed; each value stands for the interval that was rounded to it.
double quantile(const Shares& shares, double share) {
  double below = 0.0;
  for (std::size_t grey = 0; grey < shares.size(); ++grey) {
    if (below + shares[grey] >= share) {
      return static_cast<double>(grey) - 0.5 + (share - below) / shares[grey];
    }
    below += shares[grey];
  }
  return 255.0;
}

}  // namespace

Exposure exposure_of(const SensorLimits& limits, double effective_s) {
  Exposure exposure;
  exposure.shutter_s = std::clamp(effective_s / limits.least_gain, limits.least_shutter_s, limits.most_shutter_s);
  if (limits.shutter_step_s > 0) {  // downwards, so that gain can make up for the rest
    const double steps = std::floor(steps_to(exposure.shutter_s, limits.least_shutter_s, limits.shutter_step_s));
    exposure.shutter_s = limits.least_shutter_s + steps * limits.shutter_step_s;
  }
  exposure.gain = std::clamp(effective_s / exposure.shutter_s, limits.least_gain, limits.most_gain);
  if (limits.gain_step > 0) {  // to the nearest that there is
    const double most_steps = std::floor(steps_to(limits.most_gain, limits.least_gain, limits.gain_step));
    const double steps = std::floor(steps_to(exposure.gain, limits.least_gain, limits.gain_step) + 0.5);
    exposure.gain = limits.least_gain + std::min(steps, most_steps) * limits.gain_step;
  }
  return exposure;
}

ExposureControl::ExposureControl(ImageSize size, const SensorLimits& limits, const std::vector<ExposureArea>& areas,
                                 const ExposureOptions& options)
    : size_(size),
      limits_(checked(limits)),
      areas_(checked(areas, size)),
      options_(checked(options, limits)),
      effective_s_(limits.least_shutter_s * limits.least_gain) {}

ExposureReport ExposureControl::update(GreyView image, const Exposure& taken_with) {
  ExposureReport report;
  report.next = next();
  if (image.pixels == nullptr || image.width != size_.width || image.height != size_.height ||
      !(taken_with.effective_s() > 0)) {
    return report;
  }
  const Shares shares = grey_shares(image, areas_);
  const double saturated = limits_.saturated_grey;
  const double median = quantile(shares, 0.5);
  const double bright = quantile(shares, 1.0 - options_.bright_share);
  for (std::size_t grey = 0; grey < shares.size(); ++grey) {
    if (static_cast<double>(grey) >= saturated) report.saturated_share += shares[grey];
  }
  report.median_grey = median;

  const auto factor_to = [&](double target, double grey) {
    return (target - limits_.black_grey) / std::max(grey - limits_.black_grey, kLeastSignal_grey);
  };
  const double factor = std::min(factor_to(options_.target_grey, median), factor_to(options_.bright_grey, bright));
  const double least_s = limits_.least_shutter_s * limits_.least_gain;
  const double most_s = limits_.most_shutter_s * limits_.most_gain;
  double wanted_s = taken_with.effective_s() * factor;
  const bool nothing_nearer = wanted_s >= least_s && wanted_s <= most_s &&
                              exposure_of(limits_, wanted_s).effective_s() == taken_with.effective_s();
  report.settled = bright < saturated && (std::abs(factor - 1.0) <= options_.hold || nothing_nearer);
  if (median >= saturated || bright >= saturated) {
    wanted_s = taken_with.effective_s() / (median >= saturated ? kLargestFactor : kBrightPartFactor);
    effective_s_ = std::min(effective_s_, wanted_s);
  } else if (factor > kLargestFactor) {
    wanted_s = taken_with.effective_s() * kLargestFactor;
    effective_s_ = std::max(effective_s_, wanted_s);
  } else if (!report.settled) {
    effective_s_ = std::sqrt(effective_s_ * wanted_s);
  }

  effective_s_ = std::clamp(effective_s_, least_s, most_s);
  report.too_dark = !report.settled && wanted_s > most_s;
  report.too_bright = !report.settled && wanted_s < least_s;
  report.next = next();
  report.state = report.too_dark || report.too_bright ? State::kDegraded : State::kOk;
  return report;
}

}  // namespace raybundle
