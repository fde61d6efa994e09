// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "stereo_exposure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "state_name.hpp"

namespace raybundle::apps {
namespace {

// What small cameras commonly can, and what these images were taken with.
SensorLimits limits_around(const Exposure& taken_with) {
  return {.least_shutter_s = std::min(30e-6, taken_with.shutter_s),
          .most_shutter_s = std::max(33e-3, taken_with.shutter_s),
          .least_gain = std::min(1.0, taken_with.gain),
          .most_gain = std::max(16.0, taken_with.gain)};
}

}  // namespace

ExposureAdvice::ExposureAdvice(ImageSize size, const std::vector<double>& taken_with)
    : taken_with_{1e-3 * taken_with[0], taken_with[1]}, control_(size, limits_around(taken_with_)) {}

nlohmann::ordered_json ExposureAdvice::advise(GreyView image) {
  constexpr int kSteps = 40;  // the control goes half of the way with each image: here it has one image for all of it
  for (int i = 0; i < kSteps; ++i) report_ = control_.update(image, taken_with_);
  return {{"state", state_name(report_.state)},
          {"median_grey", report_.median_grey},
          {"saturated_share", report_.saturated_share},
          {"right", report_.settled},
          {"next", {{"shutter_ms", 1e3 * report_.next.shutter_s}, {"gain", report_.next.gain}}}};
}

std::string ExposureAdvice::words() const {
  const std::string seen =
      fmt::format("median grey {:.0f}, {:.1f} % saturated", report_.median_grey, 100 * report_.saturated_share);
  if (report_.settled) return "exposure right: " + seen;
  return fmt::format("exposure: {}; next {:.3g} ms, gain {:.3g}{}", seen, 1e3 * report_.next.shutter_s,
                     report_.next.gain, report_.state == State::kOk ? "" : ", the limit");
}

}  // namespace raybundle::apps
