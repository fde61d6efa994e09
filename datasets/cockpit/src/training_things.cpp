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

// Wings beside a head, each a padded plate on the child's side of the back.
void add_wings(const Rigid3& vehicle_from_tub, double half_width_m, double height_m, double deep_m,
               const CabinMaterial& cover, Meshes& meshes) {
  for (const double side : {-1.0, 1.0}) {
    const Eigen::Vector3d centre(0.5 * deep_m + 0.01, side * half_width_m, height_m);
    meshes.push_back(placed(rounded_box({0.5 * deep_m, 0.022, 0.09}, 0.6),
                            {vehicle_from_tub.rotation * about_z(-0.2 * side), vehicle_from_tub * centre},
                            CabinPart::kChildSeat, cover));
  }
}

// A hood over the head end: a part of a tube across.
void add_hood(const Rigid3& vehicle_from_tub, double half_width_m, double height_m, double reach_rad, double radius_m,
              const CabinMaterial& cover, Meshes& meshes) {
  const auto hood = grid_mesh(12, 6, [&](double u, double v) {
    const double angle = reach_rad * v - 0.1, arch = std::sin(M_PI * u);
    return Eigen::Vector3d(radius_m * std::sin(angle) * (0.7 + 0.3 * arch) + 0.02, half_width_m * std::cos(M_PI * u),
                           height_m - radius_m * (1 - std::cos(angle)) + 0.04 * arch);
  });
  meshes.push_back(placed(hood, vehicle_from_tub, CabinPart::kChildSeat, cover));
}

}  // namespace

ChildPlace add_booster(const SeatSetting& seat, Random& random, Meshes& meshes) {
  const SeatAxes axes = axes_of(seat);
  const CabinMaterial cover = shell_plastic(random);
  const double thick = random.uniform(0.08, 0.16), length = random.uniform(0.15, 0.20),
               half_width = random.uniform(0.17, 0.22);
  const Eigen::Quaterniond pitched = about_y(-seat.cushion_pitch_rad);
  const double across = random.uniform(-0.03, 0.03), back_gap = random.uniform(0.01, 0.05);
  const auto add_box = [&](double along, double side, double above, const Eigen::Vector3d& semi, double roundness) {
    meshes.push_back(placed(rounded_box(semi, roundness), {pitched, on_cushion(axes, along, across + side, above)},
                            CabinPart::kChildSeat, cover));
  };
  add_box(length + back_gap, 0, 0.5 * thick, {length, half_width, 0.5 * thick}, random.uniform(0.25, 0.6));
  const double arm = random.uniform(0.02, 0.06), arm_length = random.uniform(0.08, 0.14);
  for (const double side : {-1.0, 1.0}) {
    add_box(length - 0.02, side * (half_width - 0.02), thick + 0.6 * arm, {arm_length, 0.022, arm}, 0.5);
  }
  if (random.chance(0.5)) {  // with a back and wings
    const double height = random.uniform(0.54, 0.70), half = half_width - random.uniform(0.01, 0.03);
    const Tub back{height, 0.05, half, random.uniform(0.04, 0.16)};
    const Rigid3 pose{about_y(-seat.recline_rad), on_cushion(axes, 0.06, across, thick)};
    back.add(pose, cover, cover, meshes);
    if (random.chance(0.5))
      add_wings(pose, half - random.uniform(0.0, 0.03), height - 0.09, random.uniform(0.08, 0.18), cover, meshes);
  }
  return {on_cushion(axes, 0.16, across, thick + 0.075), seat.recline_rad, false};
}

ChildPlace add_forward_baby_seat(const SeatSetting& seat, Random& random, Meshes& meshes) {
  const SeatAxes axes = axes_of(seat);
  const CabinMaterial shell = shell_plastic(random), cover = cloth(random, 0.10, 0.85);
  const double base = random.uniform(0.03, 0.16), across = random.uniform(-0.03, 0.03);
  const double recline = seat.recline_rad + random.uniform(-0.15, 0.12);
  const Tub tub{random.uniform(0.52, 0.72), random.uniform(0.26, 0.38), random.uniform(0.16, 0.22),
                random.uniform(0.06, 0.20)};
  const Rigid3 pose{about_y(-recline), on_cushion(axes, random.uniform(0.07, 0.12), across, base)};
  tub.add(pose, shell, cover, meshes);
  const double half_base = random.uniform(0.14, 0.20);
  meshes.push_back(placed(rounded_box({half_base, tub.half_width_m - 0.02, 0.5 * base}, random.uniform(0.2, 0.6)),
                          {about_y(-seat.cushion_pitch_rad), on_cushion(axes, half_base + 0.06, across, 0.5 * base)},
                          CabinPart::kChildSeat, shell));
  if (random.chance(0.5)) {
    add_wings(pose, tub.half_width_m - random.uniform(0.0, 0.04), tub.back_m - random.uniform(0.07, 0.14),
              random.uniform(0.08, 0.20), cover, meshes);
  }
  const double front = random.uniform(0.20, 0.28), above = random.uniform(0.10, 0.17),
               deep = random.uniform(0.03, 0.06);
  if (random.chance(0.3)) {  // a table that holds the child instead of a harness
    meshes.push_back(placed(rounded_box({deep, tub.half_width_m - 0.02, deep}, 0.7),
                            {pose.rotation, pose * Eigen::Vector3d(front, 0, above)}, CabinPart::kChildSeat, cover));
  }
  return {pose * Eigen::Vector3d(0.11, 0, 0.09), recline, false};
}

ChildPlace add_rear_baby_seat(const SeatSetting& seat, Random& random, Meshes& meshes) {
  const SeatAxes axes = axes_of(seat);
  const CabinMaterial shell = shell_plastic(random), cover = cloth(random, 0.10, 0.85);
  const double base = random.uniform(0.02, 0.14), across = random.uniform(-0.03, 0.03);
  const double recline = random.uniform(0.55, 1.05);  // from a convertible seat for toddlers to a lying newborn
  const Tub tub{random.uniform(0.44, 0.66), random.uniform(0.20, 0.34), random.uniform(0.16, 0.22),
                random.uniform(0.08, 0.20)};
  const Eigen::Quaterniond turned = about_z(M_PI) * about_y(-recline);
  // The tub's lowest point rests on the base: the child's feet are at the seat's back.
  const Eigen::Vector3d foot = on_cushion(axes, random.uniform(0.28, 0.38), across, base + 0.04);
  tub.add({turned, foot}, shell, cover, meshes);
  const double half_base = random.uniform(0.17, 0.25);
  meshes.push_back(placed(rounded_box({half_base, tub.half_width_m - 0.03, 0.5 * base + 0.03}, 0.4),
                          {about_y(-seat.cushion_pitch_rad), on_cushion(axes, half_base + 0.06, across, 0.5 * base)},
                          CabinPart::kChildSeat, shell));
  if (random.chance(0.5)) {  // the rim closes around the feet
    meshes.push_back(placed(rounded_box({0.03, tub.half_width_m, random.uniform(0.05, 0.10)}, 0.7),
                            {turned, foot + turned * Eigen::Vector3d(tub.seat_m, 0, 0.08)}, CabinPart::kChildSeat,
                            shell));
  }
  if (random.chance(0.4)) {
    add_hood({turned, foot}, tub.half_width_m + 0.01, tub.back_m, random.uniform(0.9, 1.7), random.uniform(0.20, 0.28),
             cover, meshes);
  }
  if (random.chance(0.5)) {  // a handle over the child
    const double reach = random.uniform(0.45, 0.75) * tub.back_m;
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
    // What a coarse grid of beams can tell from a cushion, some 5 cm thick: crates and bags; flat parcels; tall ones
    // that lean on the back; long ones that lie.
    const int shape = random.below(5);
    Eigen::Vector3d semi(random.uniform(0.06, 0.20), random.uniform(0.06, 0.20), random.uniform(0.05, 0.22));
    if (shape == 2) semi = {random.uniform(0.10, 0.20), random.uniform(0.10, 0.20), random.uniform(0.025, 0.05)};
    if (shape == 3) semi = {random.uniform(0.05, 0.12), random.uniform(0.10, 0.22), random.uniform(0.20, 0.32)};
    if (shape == 4) semi = {random.uniform(0.05, 0.09), random.uniform(0.12, 0.24), random.uniform(0.05, 0.09)};
    if (count > 1 && shape != 2) semi *= 0.8;
    const double across = count == 1 ? random.uniform(-0.10, 0.10) : -0.14 + 0.28 * i / (count - 1);
    const double along = (shape == 3 ? semi.x() : semi.head<2>().maxCoeff()) + random.uniform(0.05, 0.20);
    const double roundness = random.chance(0.5) ? 0.12 : random.uniform(0.3, 0.9);
    const double yaw = random.uniform(-0.6, 0.6) * (shape == 3 ? 0.2 : 1.0);
    const Eigen::Quaterniond turned =
        about_y(shape == 3 ? -0.7 * seat.recline_rad : -seat.cushion_pitch_rad) * about_z(yaw);
    const double lean_m = shape == 3 ? semi.z() * std::sin(0.7 * seat.recline_rad) : 0.0;
    meshes.push_back(placed(rounded_box(semi, roundness),
                            {turned, on_cushion(axes, std::max(along - lean_m, 0.10), across, semi.z())},
                            CabinPart::kObject, cloth(random, 0.08, 0.85)));
  }
}

}  // namespace raybundle::training
