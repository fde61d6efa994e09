// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "shapes.hpp"
#include "training.hpp"

namespace raybundle::training {
namespace {

CabinMaterial shell_plastic(Random& random) {
  CabinMaterial material = cloth(random, 0.15, 0.7);
  material.specular = random.uniform(0.0, 0.08);
  return material;
}

// A place on the seat: so far along the cushion from the back's plane, across, and above the cushion's plane.
Eigen::Vector3d on_cushion(const SeatAxes& axes, double along, double across, double above) {
  return axes.bight + along * axes.cushion_forward + above * axes.cushion_normal + Eigen::Vector3d(0, across, 0);
}

// A tub, open towards the child: back, sides and seat. x to where the child looks, z along its back.
struct Tub {
  double back_m, seat_m, half_width_m, wing_m;

  void add(const Rigid3& vehicle_from_tub, const CabinMaterial& shell, const CabinMaterial& cover,
           Meshes& meshes) const {
    const Polyline inside{{wing_m * 0.2, back_m}, {0.03, 0.75 * back_m}, {0.0, 0.4 * back_m}, {0.01, 0.12 * back_m},
                          {0.06, 0.02},           {0.5 * seat_m, 0.0},   {seat_m, 0.05}};
    Polyline outside = inside;
    for (Eigen::Vector2d& corner : outside) corner += Eigen::Vector2d(-0.035, -0.035);
    meshes.push_back(
        placed(swept(inside, -half_width_m, half_width_m), vehicle_from_tub, CabinPart::kChildSeat, cover));
    meshes.push_back(
        placed(swept(outside, -half_width_m, half_width_m), vehicle_from_tub, CabinPart::kChildSeat, shell));
    for (const double side : {-half_width_m, half_width_m}) {
      const auto wall = grid_mesh(6, 12, [&](double u, double v) {
        const double at = v * static_cast<double>(inside.size() - 1);
        const auto i = std::min(static_cast<std::size_t>(at), inside.size() - 2);
        const Eigen::Vector2d low = outside[i] + (at - static_cast<double>(i)) * (outside[i + 1] - outside[i]);
        const double height = wing_m * (0.75 + 0.25 * std::cos(2 * M_PI * v));
        const Eigen::Vector2d inward = Eigen::Vector2d(0.9 * (1 - 0.6 * v), 0.35 + 0.5 * v) * height;
        return Eigen::Vector3d(low.x() + u * inward.x(), side * (1 + 0.06 * u), low.y() + u * inward.y());
      });
      meshes.push_back(placed(wall, vehicle_from_tub, CabinPart::kChildSeat, shell));
    }
  }
};

}  // namespace

ChildPlace add_booster(const SeatSetting& seat, Random& random, Meshes& meshes) {
  const SeatAxes axes = axes_of(seat);
  const CabinMaterial cover = shell_plastic(random);
  const double thick = random.uniform(0.09, 0.14), length = random.uniform(0.17, 0.20),
               half_width = random.uniform(0.19, 0.22);
  const Eigen::Quaterniond pitched = about_y(-seat.cushion_pitch_rad);
  const double across = random.uniform(-0.02, 0.02);
  const auto add_box = [&](double along, double side, double above, const Eigen::Vector3d& semi, double roundness) {
    meshes.push_back(placed(rounded_box(semi, roundness), {pitched, on_cushion(axes, along, across + side, above)},
                            CabinPart::kChildSeat, cover));
  };
  add_box(length + 0.03, 0, 0.5 * thick, {length, half_width, 0.5 * thick}, 0.35);
  for (const double side : {-1.0, 1.0}) {
    add_box(length - 0.02, side * (half_width - 0.02), thick + 0.04, {0.12, 0.022, 0.05}, 0.5);
  }
  if (random.chance(0.5)) {  // with a back and wings
    const double height = random.uniform(0.58, 0.68), half = half_width - 0.02;
    const Tub back{height, 0.05, half, random.uniform(0.08, 0.14)};
    const Eigen::Vector3d foot = on_cushion(axes, 0.06, across, thick);
    back.add({about_y(-seat.recline_rad), foot}, cover, cover, meshes);
  }
  return {on_cushion(axes, 0.16, across, thick + 0.075), seat.recline_rad, false};
}

ChildPlace add_forward_baby_seat(const SeatSetting& seat, Random& random, Meshes& meshes) {
  const SeatAxes axes = axes_of(seat);
  const CabinMaterial shell = shell_plastic(random), cover = cloth(random, 0.15, 0.7);
  const double base = random.uniform(0.08, 0.14), across = random.uniform(-0.02, 0.02);
  const double recline = seat.recline_rad + random.uniform(-0.08, 0.08);
  const Tub tub{random.uniform(0.56, 0.68), random.uniform(0.30, 0.36), random.uniform(0.17, 0.21),
                random.uniform(0.12, 0.18)};
  const Eigen::Vector3d foot = on_cushion(axes, 0.10, across, base);
  tub.add({about_y(-recline), foot}, shell, cover, meshes);
  meshes.push_back(placed(rounded_box({0.18, tub.half_width_m - 0.02, 0.5 * base}, 0.4),
                          {about_y(-seat.cushion_pitch_rad), on_cushion(axes, 0.24, across, 0.5 * base)},
                          CabinPart::kChildSeat, shell));
  return {foot + Eigen::Vector3d(0.10, 0, 0.05), recline, false};
}

ChildPlace add_rear_baby_seat(const SeatSetting& seat, Random& random, Meshes& meshes) {
  const SeatAxes axes = axes_of(seat);
  const CabinMaterial shell = shell_plastic(random), cover = cloth(random, 0.15, 0.7);
  const double base = random.uniform(0.05, 0.12), across = random.uniform(-0.02, 0.02);
  const double recline = random.uniform(0.65, 0.90);  // half lying
  const Tub tub{random.uniform(0.46, 0.60), random.uniform(0.26, 0.32), random.uniform(0.17, 0.21),
                random.uniform(0.11, 0.16)};
  const Eigen::Quaterniond turned = about_z(M_PI) * about_y(-recline);
  // The tub's lowest point rests on the base: the child's feet are at the seat's back.
  const Eigen::Vector3d foot = on_cushion(axes, random.uniform(0.30, 0.36), across, base + 0.04);
  tub.add({turned, foot}, shell, cover, meshes);
  meshes.push_back(placed(rounded_box({0.22, tub.half_width_m - 0.03, 0.5 * base + 0.03}, 0.4),
                          {about_y(-seat.cushion_pitch_rad), on_cushion(axes, 0.28, across, 0.5 * base)},
                          CabinPart::kChildSeat, shell));
  if (random.chance(0.6)) {  // a handle over the child
    const double reach = 0.6 * tub.back_m;
    const auto handle = grid_mesh(20, 6, [&](double u, double v) {
      const double angle = M_PI * u, around = 2 * M_PI * v, r = 0.014;
      const double lift = 0.25 + r * std::cos(around);
      return Eigen::Vector3d(0.10 + lift * std::sin(angle),
                             (tub.half_width_m + 0.02) * std::cos(angle) * (1 + r * std::cos(around)),
                             reach + r * std::sin(around));
    });
    meshes.push_back(placed(handle, {turned, foot}, CabinPart::kChildSeat, shell));
  }
  return {foot + turned * Eigen::Vector3d(0.09, 0, 0.07), recline, true};
}

void add_objects(const SeatSetting& seat, Random& random, Meshes& meshes) {
  const SeatAxes axes = axes_of(seat);
  const int count = 1 + random.below(3);
  for (int i = 0; i < count; ++i) {
    const bool box = random.chance(0.5);
    Eigen::Vector3d semi(random.uniform(0.06, 0.20), random.uniform(0.06, 0.20), random.uniform(0.05, 0.22));
    if (count > 1) semi *= 0.75;
    const double across = count == 1 ? random.uniform(-0.05, 0.05) : -0.14 + 0.28 * i / (count - 1);
    const Eigen::Vector3d centre =
        on_cushion(axes, 0.05 + semi.head<2>().maxCoeff() + random.uniform(0.0, 0.08), across, semi.z());
    const Eigen::Quaterniond turned = about_y(-seat.cushion_pitch_rad) * about_z(random.uniform(-0.6, 0.6));
    meshes.push_back(placed(rounded_box(semi, box ? 0.12 : random.uniform(0.4, 0.8)), {turned, centre},
                            CabinPart::kObject, cloth(random, 0.15, 0.75)));
  }
}

}  // namespace raybundle::training
