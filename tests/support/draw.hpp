// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

namespace raybundle::testing {

/// Numbers that depend on the seed alone, whatever the standard library: its distributions differ, and Eigen's Random
/// is that of C.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : engine_(seed) {}

  double uniform(double low, double high) { return low + (high - low) * std::generate_canonical<double, 53>(engine_); }
  double log_uniform(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }
  double normal(double sigma = 1.0) {  // Box and Muller
    const double radius = std::sqrt(-2 * std::log(1 - uniform(0, 1))), angle = 2 * M_PI * uniform(0, 1);
    return sigma * radius * std::cos(angle);
  }
  bool chance(double probability) { return uniform(0, 1) < probability; }
  int integer(int low, int high) {  // both included
    return std::min(high, low + static_cast<int>(uniform(0, 1) * (high - low + 1)));
  }
  Eigen::Vector3d direction() {
    const double z = uniform(-1, 1), azimuth = uniform(0, 2 * M_PI), r = std::sqrt(1 - z * z);
    return {r * std::cos(azimuth), r * std::sin(azimuth), z};
  }

  template <typename Container>
  const auto& pick(const Container& container) {
    return container[static_cast<std::size_t>(integer(0, static_cast<int>(container.size()) - 1))];
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace raybundle::testing
