// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "held_out.hpp"
#include "shapes.hpp"

namespace raybundle::held_out {
namespace {

constexpr double kRollRadius_m = 0.06, kRollStep_m = 0.07;
// Rolls stand so far above the seat's plane and their seams so far below it that the plane is their mean.
constexpr double kRollRise_m = 0.0036;

struct RollPad {
  Eigen::Vector3d start, along, out;
  double length_m, half_width_m, side_radius_m;

  Eigen::Vector3d at(double forward, double across, double above) const {
    return start + forward * along + above * out + Eigen::Vector3d(0, across, 0);
  }

  void add(const CabinMaterial& cover, Meshes& meshes) const {
    const auto roll = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius) {
      meshes.push_back(limb(from, to, radius, radius, CabinPart::kSeat, cover));
    };
    for (double forward = -0.03; forward < length_m; forward += kRollStep_m) {
      const double half = half_width_m - side_radius_m - kRollRadius_m * 0.5, above = kRollRise_m - kRollRadius_m;
      roll(at(forward, -half, above), at(forward, half, above), kRollRadius_m);
    }
    for (const double side : {-1.0, 1.0}) {
      const double across = side * (half_width_m - side_radius_m), above = 0.028 - side_radius_m;
      roll(at(0.02, across, above), at(length_m - 0.03, across, above - 0.01), side_radius_m);
    }
  }
};

}  // namespace

CabinMaterial fabric(Random& random, double low_albedo, double high_albedo) {
  CabinMaterial material;
  material.albedo = low_albedo + (high_albedo - low_albedo) * random.uniform() * random.uniform();
  material.specular = random.chance(0.3) ? random.uniform(0.01, 0.06) : 0.0;
  material.gloss = 8;
  material.contrast = random.uniform(0.08, 0.5);
  material.grain_m = random.uniform(0.005, 0.016);
  material.seed = static_cast<std::uint32_t>(random.below(1 << 30));
  return material;
}

void add_seat(const SeatSetting& seat, Random& random, Meshes& meshes) {
  const CabinMaterial cover = fabric(random, 0.12, 0.7);
  const SeatAxes axes = axes_of(seat);
  const double half_width = random.uniform(0.235, 0.255);
  const RollPad cushion{axes.bight, axes.cushion_forward, axes.cushion_normal, random.uniform(0.46, 0.52), half_width,
                        0.055};
  const RollPad back{axes.bight, axes.back_up, axes.back_normal, random.uniform(0.62, 0.68), half_width - 0.01, 0.05};
  cushion.add(cover, meshes);
  back.add(cover, meshes);
  const Eigen::Quaterniond pitched = about_y(-seat.cushion_pitch_rad), reclined = about_y(-seat.recline_rad);
  meshes.push_back(placed(rounded_box({0.5 * cushion.length_m, half_width - 0.02, 0.07}, 0.25),
                          {pitched, cushion.at(0.5 * cushion.length_m, 0, -0.12)}, CabinPart::kSeat, cover));
  meshes.push_back(placed(rounded_box({0.05, half_width - 0.04, 0.5 * back.length_m}, 0.25),
                          {reclined, back.at(0.5 * back.length_m, 0, -0.11)}, CabinPart::kSeat, cover));
  // Back and headrest are one piece: shoulders, then a narrower top.
  meshes.push_back(placed(rounded_box({0.055, 0.19, 0.07}, 0.6), {reclined, back.at(back.length_m + 0.02, 0, -0.055)},
                          CabinPart::kSeat, cover));
  meshes.push_back(placed(rounded_box({random.uniform(0.05, 0.065), random.uniform(0.10, 0.13), 0.12}, 0.7),
                          {reclined, back.at(back.length_m + 0.13, 0, -0.04)}, CabinPart::kSeat, cover));
}

Eigen::AlignedBox3d Screen::bounds() const {
  const double c = std::cos(pitch_rad), s = std::abs(std::sin(pitch_rad));
  const Eigen::Vector3d reach(c * semi_m.x() + s * semi_m.z(), semi_m.y(), s * semi_m.x() + c * semi_m.z());
  return {centre - reach, centre + reach};
}

Screen screen_of(const CabinLayout& layout) {
  return {{layout.dashboard_x_m + 0.03, layout.middle_y_m, layout.dashboard_top_m + 0.03}, {0.015, 0.13, 0.07}, -0.2};
}

void add_car(const CabinLayout& layout, Random& random, Meshes& meshes) {
  const CabinMaterial plastic = fabric(random, 0.08, 0.5), trim = fabric(random, 0.15, 0.6),
                      lining = fabric(random, 0.35, 0.8);
  const double x = layout.dashboard_x_m, top = layout.dashboard_top_m, middle = layout.middle_y_m;
  const double half = middle - layout.door_y_m, floor = -0.27;
  const Eigen::Quaterniond upright = Eigen::Quaterniond::Identity();
  const auto block = [&](const Eigen::Vector3d& centre, const Eigen::Vector3d& semi, double roundness,
                         const CabinMaterial& material, CabinPart part, double pitch_rad) {
    meshes.push_back(
        placed(rounded_box(semi, roundness), {pitch_rad == 0 ? upright : about_y(pitch_rad), centre}, part, material));
  };
  // The dashboard: a bar across the car, a glove box below it, a screen in the middle.
  block({x + 0.20, middle, top - 0.09}, {0.20, half, 0.09}, 0.3, plastic, CabinPart::kDashboard, 0);
  block({x + 0.20, middle, top - 0.32}, {0.13, half, 0.16}, 0.25, trim, CabinPart::kDashboard, 0);
  const Screen screen = screen_of(layout);
  block(screen.centre, screen.semi_m, 0.2, plastic, CabinPart::kDashboard, screen.pitch_rad);
  block({x + 0.55, middle, top - 0.06}, {0.30, half, 0.05}, 0.2, plastic, CabinPart::kDashboard, 0);
  block({x + 0.50, middle, 0.0}, {0.05, half, 0.40}, 0.1, plastic, CabinPart::kDashboard, 0.3);
  block({-0.2, middle, floor - 0.05}, {1.3, half, 0.05}, 0.1, fabric(random, 0.05, 0.3), CabinPart::kCar, 0);
  block({-0.55, middle, layout.roof_m + 0.05}, {0.85, half, 0.05}, 0.1, lining, CabinPart::kCar, 0);
  for (const double side : {-1.0, 1.0}) {
    const double y = middle + side * (half + 0.05);
    block({-0.2, y, 0.06}, {1.2, 0.05, 0.36}, 0.1, trim, CabinPart::kCar, 0);
    block({0.10, middle + side * (half - 0.01), 0.17}, {0.35, 0.05, 0.03}, 0.5, plastic, CabinPart::kCar, 0);
    block({-0.40, y, 0.7}, {0.07, 0.05, 0.40}, 0.2, lining, CabinPart::kCar, 0);
  }
  block({0.25, middle, -0.14}, {0.60, 0.085, 0.13}, 0.2, plastic, CabinPart::kCar, 0);
  block({-0.12, middle, 0.02}, {0.16, 0.07, 0.06}, 0.4, trim, CabinPart::kCar, 0);
  const CabinMaterial cover = fabric(random, 0.12, 0.7);
  const double driver = 2 * middle;
  block({0.10, driver, -0.13}, {0.25, 0.24, 0.09}, 0.5, cover, CabinPart::kCar, -0.2);
  block({-0.26, driver, 0.25}, {0.08, 0.23, 0.36}, 0.5, cover, CabinPart::kCar, -0.4);
  block({-0.44, driver, 0.66}, {0.06, 0.11, 0.10}, 0.7, cover, CabinPart::kCar, -0.4);
  block({-0.90, middle, -0.08}, {0.26, half - 0.05, 0.10}, 0.4, cover, CabinPart::kCar, -0.15);
  block({-1.22, middle, 0.28}, {0.09, half - 0.05, 0.38}, 0.4, cover, CabinPart::kCar, -0.35);
}

}  // namespace raybundle::held_out
