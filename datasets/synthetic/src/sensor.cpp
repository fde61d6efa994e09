// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/synthetic/sensor.hpp"

#include <algorithm>
#include <cmath>

#include "raybundle/synthetic/random.hpp"

namespace raybundle {
namespace {

constexpr double kFewElectrons = 20;  // below, the Poisson distribution is followed step by step

double range_of(const SimulatedSensor& sensor) { return std::exp2(sensor.bits) - 1.0; }

// In (0, 1): a function of key and counter.
double uniform_at(std::uint64_t key, std::uint64_t counter) {
  return (static_cast<double>(mixed_bits(key + counter) >> 11) + 0.5) * 0x1p-53;
}

// The quantile of the Poisson distribution; of large means by its Cornish-Fisher expansion to the skewness.
double poisson_quantile(double mean, double p) {
  if (mean >= kFewElectrons) {
    const double z = normal_quantile(p);
    return std::max(0.0, mean + std::sqrt(mean) * z + (z * z - 1) / 6);
  }
  double count = 0, term = std::exp(-mean), sum = term;
  while (sum < p && term > 1e-18) {
    term *= mean / ++count;
    sum += term;
  }
  return count;
}

}  // namespace

std::uint64_t random_key(std::uint64_t seed, std::uint64_t stream, std::uint64_t purpose) {
  return mixed_bits(mixed_bits(mixed_bits(seed) + stream) + purpose);
}

double grey_from_light(const SimulatedSensor& sensor, double light_W_m2) {
  return range_of(sensor) * (sensor.black_level + sensor.exposure * light_W_m2 / sensor.white_W_m2);
}

GreyImage read_out(const SimulatedSensor& sensor, const LightImage& light, bool noise, std::uint64_t key) {
  const double range = range_of(sensor);
  GreyImage image{light.size, sensor.bits, {}};
  image.values.reserve(light.values.size());
  for (std::size_t i = 0; i < light.values.size(); ++i) {
    double electrons = sensor.full_well_e * sensor.exposure * light.values[i] / sensor.white_W_m2;
    if (noise) electrons = poisson_quantile(electrons, uniform_at(key, 2 * i));
    electrons = std::min(electrons, sensor.full_well_e);
    if (noise) electrons += sensor.read_noise_e * normal_quantile(uniform_at(key, 2 * i + 1));
    const double grey = range * (sensor.black_level + electrons / sensor.full_well_e);
    image.values.push_back(static_cast<std::uint16_t>(std::clamp(std::floor(grey + 0.5), 0.0, range)));
  }
  return image;
}

// A gamma distribution, as of many independent patterns. Source: Wilson and Hilferty 1931.
void add_speckle(LightImage& light, double contrast, std::uint64_t key) {
  if (contrast <= 0) return;
  const double spread = contrast / 3;
  for (std::size_t i = 0; i < light.values.size(); ++i) {
    if (light.values[i] == 0) continue;
    const double root = 1 - spread * spread + spread * normal_quantile(uniform_at(key, i));
    light.values[i] *= static_cast<float>(std::pow(std::max(0.0, root), 3));
  }
}

double grey_sigma(const SimulatedSensor& sensor, double grey) {
  const double grey_per_electron = range_of(sensor) / sensor.full_well_e;
  const double electrons = std::max(0.0, grey - sensor.black_level * range_of(sensor)) / grey_per_electron;
  const double noise_e2 = electrons + sensor.read_noise_e * sensor.read_noise_e;
  return std::sqrt(grey_per_electron * grey_per_electron * noise_e2 + 1.0 / 12.0);
}

}  // namespace raybundle
