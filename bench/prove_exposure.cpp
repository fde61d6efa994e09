// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// The loop of exposure in simulated cabins: a pair's left camera looks at a passenger while the light changes at once,
// as into and out of a tunnel and from shade into sun; ExposureControl sets its shutter and gain through ImageSensor,
// with one frame of latency. Bars: frames until the exposure stays within 5 % of where it ends (8 stops take three
// jumps of up to 3 stops, then halves, each a frame late), and turns of the exposure on the way: a saturated image says
// only that less light is wanted, so that one turn back is right, and a second one is an oscillation; and cabins whose
// last image is not as bright as wanted, of which there may be none: a control that never moves has them.
//
// usage: prove_exposure [cabins of each generator, default 20]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <utility>
#include <vector>

#include "raybundle/cockpit/cabin_renderer.hpp"
#include "raybundle/stereo/exposure_control.hpp"
#include "simulated_sensor.hpp"
#include "support/bar.hpp"

namespace {

using namespace raybundle;
using namespace raybundle::bench;

constexpr int kFramesToSettle = 14, kMostTurns = 1;
constexpr Unit kCount{"", 1.0};
constexpr int kFrames = 40;                       // of each light
constexpr double kStays = 0.05;                   // of the exposure; less is noise, or a step of the sensor
constexpr double kGreyPerW_s = 255 / 8.0 / 1e-3;  // 8 W/m² on a white surface fill the range in 1 ms

struct Light {
  const char* name;
  double ambient_W_m2, sun_W_m2;  // in the band that the cameras see
};
constexpr Light kLights[] = {{"day", 2, 0},         {"sun", 5, 100}, {"tunnel", 0.02, 0},
                             {"out of it", 5, 100}, {"shade", 1, 0}, {"night", 0, 0}};

// Light on the pixels is the sum of its sources: each is rendered once, with a brightness of 1.
struct Sources {
  ImageSize size;
  std::vector<double> ambient, sun, lamp;  // [W/m² on a white surface]
};

std::vector<double> seen(CabinSensor sensor, Cockpit cockpit, const CabinLight& light, double lamp_W_m2,
                         double white_W_m2) {
  cockpit.light = light;
  sensor.illuminator_W_m2 = lamp_W_m2;
  sensor.automatic_exposure = false;
  SimulatedSensor& reading = sensor.rig.cameras[0].sensor;
  reading.bits = 12, reading.black_level = 0.0, reading.exposure = 1.0, reading.white_W_m2 = white_W_m2;
  const GreyImage image = CabinRenderer(sensor).image(CabinScene(cockpit), 0, {.noise = false, .samples = 1});
  std::vector<double> values;
  for (const std::uint16_t value : image.values) values.push_back(value / 4095.0 * white_W_m2);
  return values;
}

Sources sources_of(CockpitGenerator generator, std::uint64_t seed) {
  constexpr double kDull_W_m2 = 2.0, kShiny_W_m2 = 4.0, kNear_W_m2 = 60.0;  // what is brighter saturates any sensor
  const CabinSensor sensor = stereo_sensor(generator, seed);
  const Cockpit cockpit = make_cockpit({generator, seed, CabinClass::kPassenger, 0.0});
  CabinLight sunny{.ambient_W_m2 = 0.0, .sun_W_m2 = 1.0, .sun_direction = Eigen::Vector3d(0.5, -0.6, 0.6).normalized()};
  return {sensor.rig.cameras[0].camera.size, seen(sensor, cockpit, {.ambient_W_m2 = 1.0}, 0.0, kDull_W_m2),
          seen(sensor, cockpit, sunny, 0.0, kShiny_W_m2),
          seen(sensor, cockpit, {.ambient_W_m2 = 0.0}, sensor.illuminator_W_m2, kNear_W_m2)};
}

struct Settling {
  int frames = 0, turns = 0;
  bool too_dark = false, too_bright = false;  // the last image
};

Settling settling_of(const std::vector<double>& exposures_s) {
  Settling settling;
  double turned_at = exposures_s.front();
  int direction = 0;
  for (std::size_t i = 1; i < exposures_s.size(); ++i) {
    if (std::abs(exposures_s[i] / exposures_s.back() - 1.0) > kStays) settling.frames = static_cast<int>(i);
    const double change = exposures_s[i] / turned_at - 1.0;
    if (std::abs(change) < kStays) continue;
    const int now = change > 0 ? 1 : -1;
    settling.turns += direction != 0 && now != direction;
    direction = now;
    turned_at = exposures_s[i];
  }
  return settling;
}

// The sensor and its control in one cabin.
class Loop {
 public:
  explicit Loop(Sources sources)
      : sources_(std::move(sources)),
        sensor_(limits(), 1, 1),
        control_(sources_.size, limits()),
        pixels_(sources_.ambient.size()) {}

  Settling follow(const Light& light) {
    sensor_.light.resize(pixels_.size());
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      sensor_.light[i] = kGreyPerW_s * (light.ambient_W_m2 * sources_.ambient[i] + light.sun_W_m2 * sources_.sun[i] +
                                        sources_.lamp[i]);
    }
    std::vector<double> exposures_s{control_.next().effective_s()};
    for (int frame = 0; frame < kFrames; ++frame) {
      const ImageView<std::uint8_t> image{pixels_.data(), sources_.size.width, sources_.size.height,
                                          sources_.size.width};
      const auto taken_with = sensor_.capture(image);
      const ExposureReport report =
          control_.update({image.pixels, image.width, image.height, image.stride}, *taken_with);
      sensor_.set(report.next);
      exposures_s.push_back(report.next.effective_s());
    }
    Settling settling = settling_of(exposures_s);
    judge_last_image(exposures_s.back(), settling);
    return settling;
  }

 private:
  // As ExposureOptions say by their defaults: the median at its aim, or less where more would leave too much bright. A
  // sensor that can do no more is not to blame.
  void judge_last_image(double exposure_s, Settling& settling) const {
    constexpr double kNear = 0.10, kNearShare = 0.03;  // of the aim's grey value, and of the share
    const ExposureOptions aim;
    std::vector<std::uint8_t> sorted = pixels_;
    std::ranges::sort(sorted);
    const double median = sorted[sorted.size() / 2];
    const auto bright = std::ranges::upper_bound(sorted, static_cast<std::uint8_t>(aim.bright_grey));
    const double share = static_cast<double>(sorted.end() - bright) / static_cast<double>(sorted.size());
    const SensorLimits sensor = limits();
    settling.too_dark = median < aim.target_grey * (1.0 - kNear) && share < aim.bright_share - kNearShare &&
                        exposure_s < 0.99 * sensor.most_shutter_s * sensor.most_gain;
    settling.too_bright = (median > aim.target_grey * (1.0 + kNear) || share > aim.bright_share + kNearShare) &&
                          exposure_s > 1.01 * sensor.least_shutter_s;
  }

  static SensorLimits limits() {
    return {.least_shutter_s = 10e-6,
            .most_shutter_s = 15e-3,
            .shutter_step_s = 10e-6,
            .most_gain = 16.0,
            .gain_step = 1.0 / 16.0};
  }

  Sources sources_;
  testing::SimulatedSensor sensor_;
  ExposureControl control_;
  std::vector<std::uint8_t> pixels_;
};

}  // namespace

int main(int argc, char** argv) {
  const int cabins = argc > 1 ? std::atoi(argv[1]) : 20;
  if (cabins < 1) {
    std::fprintf(stderr, "usage: prove_exposure [cabins of each generator, at least 1]\n");
    return 2;
  }
  Settling worst[std::size(kLights)];
  int too_dark[std::size(kLights)] = {}, too_bright[std::size(kLights)] = {};
  for (const CockpitGenerator generator : {CockpitGenerator::kTraining, CockpitGenerator::kTest}) {
    for (int cabin = 0; cabin < cabins; ++cabin) {
      Loop loop(sources_of(generator, 1 + static_cast<std::uint64_t>(cabin)));
      for (std::size_t i = 0; i < std::size(kLights); ++i) {
        const Settling settling = loop.follow(kLights[i]);
        worst[i].frames = std::max(worst[i].frames, settling.frames);
        worst[i].turns = std::max(worst[i].turns, settling.turns);
        too_dark[i] += settling.too_dark;
        too_bright[i] += settling.too_bright;
      }
    }
  }
  bool good = true;
  for (std::size_t i = 0; i < std::size(kLights); ++i) {
    std::printf("%s: ambient %g, sun %g W/m², %d cabins\n", kLights[i].name, kLights[i].ambient_W_m2,
                kLights[i].sun_W_m2, 2 * cabins);
    good &= at_most(kFramesToSettle, "frames until the exposure stays, most", worst[i].frames, kCount);
    good &= at_most(kMostTurns, "turns of the exposure, most", worst[i].turns, kCount);
    good &= at_most(0, "cabins that end too dark", too_dark[i], kCount);
    good &= at_most(0, "cabins that end too bright", too_bright[i], kCount);
  }
  return good ? 0 : 1;
}
