// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "blanket.hpp"

#include <algorithm>
#include <cmath>

#include "shapes.hpp"

namespace raybundle {
namespace {

constexpr int kCells = 26;        // each way
constexpr int kTightenings = 12;  // the tension reaches about this many cells
constexpr double kThick_m = 0.008;

}  // namespace

CabinMesh draped_blanket(const CabinScene& scene, const Eigen::Vector3d& centre, const CabinMaterial& material,
                         Random& random) {
  const Eigen::Quaterniond turned = about_z(random.uniform(-0.5, 0.5));
  const Eigen::Vector2d half(random.uniform(0.16, 0.26), random.uniform(0.16, 0.24));
  const double above = scene.cockpit().layout.roof_m - 0.15;
  const auto flat = [&](int i, int j) -> Eigen::Vector3d {
    const Eigen::Vector3d place((2.0 * i / kCells - 1) * half.x(), (2.0 * j / kCells - 1) * half.y(), 0);
    return Eigen::Vector3d(centre.x(), centre.y(), above) + turned * place;
  };
  Eigen::ArrayXXd ground(kCells + 1, kCells + 1);
  for (int j = 0; j <= kCells; ++j) {
    for (int i = 0; i <= kCells; ++i) {
      const auto hit = scene.first_hit(flat(i, j), -Eigen::Vector3d::UnitZ());
      ground(i, j) = hit ? hit->x_in_vehicle.z() + kThick_m : centre.z();
    }
  }
  // A membrane over the ground: never below it, and nowhere below the mean of its neighbours within reach.
  Eigen::ArrayXXd height = ground;
  for (int k = 0; k < kTightenings; ++k) {
    const Eigen::ArrayXXd before = height;
    for (int j = 1; j < kCells; ++j) {
      for (int i = 1; i < kCells; ++i) {
        const double mean = 0.25 * (before(i - 1, j) + before(i + 1, j) + before(i, j - 1) + before(i, j + 1));
        height(i, j) = std::max(ground(i, j), mean);
      }
    }
  }
  CabinMesh blanket = grid_mesh(kCells, kCells, [&](double u, double v) -> Eigen::Vector3d {
    const auto i = static_cast<int>(std::lround(u * kCells)), j = static_cast<int>(std::lround(v * kCells));
    const Eigen::Vector3d place = flat(i, j);
    return {place.x(), place.y(), height(i, j)};
  });
  return placed(std::move(blanket), {}, CabinPart::kBlanket, material);
}

}  // namespace raybundle
