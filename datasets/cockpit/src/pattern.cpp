// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "pattern.hpp"

#include <cmath>

namespace raybundle {
namespace {

constexpr int kLattices = 4;
constexpr float kDeviation = 0.5F;  // of the sum of the lattices

// In [-1, 1], a function of the lattice's point.
float value_at(int x, int y, int z, std::uint32_t seed) {
  std::uint32_t h = seed ^ (static_cast<std::uint32_t>(x) * 0x8da6b343u) ^
                    (static_cast<std::uint32_t>(y) * 0xd8163841u) ^ (static_cast<std::uint32_t>(z) * 0xcb1ab31fu);
  h = (h ^ (h >> 16)) * 0x7feb352du;
  h = (h ^ (h >> 15)) * 0x846ca68bu;
  return static_cast<float>(h ^ (h >> 16)) * (2.0F / 4294967295.0F) - 1.0F;
}

float smooth(float t) { return t * t * (3 - 2 * t); }

float noise(const Eigen::Vector3f& at, std::uint32_t seed) {
  const float fx = std::floor(at.x()), fy = std::floor(at.y()), fz = std::floor(at.z());
  const int x = static_cast<int>(fx), y = static_cast<int>(fy), z = static_cast<int>(fz);
  const float u = smooth(at.x() - fx), v = smooth(at.y() - fy), w = smooth(at.z() - fz);
  float sums[2];
  for (int k = 0; k < 2; ++k) {
    const float low = (1 - u) * value_at(x, y, z + k, seed) + u * value_at(x + 1, y, z + k, seed);
    const float high = (1 - u) * value_at(x, y + 1, z + k, seed) + u * value_at(x + 1, y + 1, z + k, seed);
    sums[k] = (1 - v) * low + v * high;
  }
  return (1 - w) * sums[0] + w * sums[1];
}

}  // namespace

double pattern_at(const Eigen::Vector3f& place, double grain_m, std::uint32_t seed) {
  float sum = 0;
  Eigen::Vector3f at = place / static_cast<float>(grain_m);
  for (int i = 0; i < kLattices; ++i) {
    sum += noise(at, seed + 0x9e3779b9u * static_cast<std::uint32_t>(i));
    at = 0.5F * at + Eigen::Vector3f::Constant(17.3F);
  }
  return sum / (kDeviation * std::sqrt(static_cast<float>(kLattices)));
}

}  // namespace raybundle
