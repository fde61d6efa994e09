// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "held_out.hpp"
#include "shapes.hpp"

namespace raybundle::held_out {
namespace {

// Boxes in a frame: x to where the child looks, z along the back.
struct Carpenter {
  Rigid3 vehicle_from_bench;
  CabinPart part;
  Meshes& meshes;

  void add(const CabinMesh& mesh, const Eigen::Vector3d& centre, const CabinMaterial& material, double yaw_rad = 0.0,
           double pitch_rad = 0.0) {
    const Rigid3 here{about_z(yaw_rad) * about_y(pitch_rad), centre};
    meshes.push_back(placed(mesh, vehicle_from_bench * here, part, material));
  }
};

Eigen::Vector3d on_cushion(const SeatAxes& axes, double along, double across, double above) {
  return axes.bight + along * axes.cushion_forward + above * axes.cushion_normal + Eigen::Vector3d(0, across, 0);
}

Rigid3 bench_on(const SeatSetting& seat, double along, double across, double above, double recline_rad) {
  return {about_y(-recline_rad), on_cushion(axes_of(seat), along, across, above)};
}

// Half of a hollow ellipsoid, open to the top.
CabinMesh bowl(const Eigen::Vector3d& semi, double from, double to) {
  return grid_mesh(28, 10, [&](double u, double v) {
    const double longitude = 2 * M_PI * u, latitude = from + (to - from) * v;
    return Eigen::Vector3d(semi.x() * std::cos(latitude) * std::cos(longitude),
                           semi.y() * std::cos(latitude) * std::sin(longitude), semi.z() * std::sin(latitude));
  });
}

}  // namespace

ChildPlace add_booster(const SeatSetting& seat, Random& random, Meshes& meshes) {
  const CabinMaterial cover = fabric(random, 0.15, 0.9);
  const double thick = random.uniform(0.10, 0.16), across = 0.015 * random.normal();
  Carpenter flat{bench_on(seat, 0.02, across, 0, seat.cushion_pitch_rad), CabinPart::kChildSeat, meshes};
  const double length = random.uniform(0.34, 0.40);
  flat.add(rounded_box({0.5 * length, 0.20, 0.5 * thick}, 0.6), {0.5 * length + 0.03, 0, 0.5 * thick}, cover);
  for (const double side : {-0.185, 0.185}) {
    flat.add(rounded_box({0.09, 0.03, 0.045}, 0.9), {0.20, side, thick + 0.04}, cover);
  }
  if (random.chance(0.6)) {
    Carpenter back{bench_on(seat, 0.05, across, thick, seat.recline_rad), CabinPart::kChildSeat, meshes};
    const double height = random.uniform(0.54, 0.66);
    back.add(rounded_box({0.03, 0.18, 0.5 * height}, 0.3), {0.0, 0, 0.5 * height}, cover);
    for (const double side : {-1.0, 1.0}) {
      back.add(rounded_box({0.08, 0.02, 0.09}, 0.5), {0.07, side * 0.165, height - 0.10}, cover);  // at the head
      back.add(rounded_box({0.06, 0.02, 0.12}, 0.5), {0.05, side * 0.185, 0.5 * height - 0.05}, cover);
    }
  }
  return {on_cushion(axes_of(seat), 0.17, across, thick + 0.07), seat.recline_rad, false};
}

ChildPlace add_forward_baby_seat(const SeatSetting& seat, Random& random, Meshes& meshes) {
  const CabinMaterial shell = fabric(random, 0.15, 0.9), cover = fabric(random, 0.10, 0.8);
  const double recline = seat.recline_rad + random.uniform(-0.1, 0.05), across = 0.015 * random.normal();
  const double base = random.uniform(0.06, 0.12), height = random.uniform(0.58, 0.70);
  Carpenter bench{bench_on(seat, 0.10, across, base, recline), CabinPart::kChildSeat, meshes};
  bench.add(rounded_box({0.035, 0.20, 0.5 * height}, 0.25), {-0.02, 0, 0.5 * height}, shell);
  bench.add(rounded_box({0.17, 0.19, 0.05}, 0.4), {0.16, 0, -0.01}, cover, 0, recline - seat.cushion_pitch_rad);
  for (const double side : {-1.0, 1.0}) {
    bench.add(rounded_box({0.09, 0.02, 0.12}, 0.35), {0.08, side * 0.16, height - 0.13}, cover, -0.25 * side);
    bench.add(rounded_box({0.13, 0.025, 0.10}, 0.35), {0.13, side * 0.20, 0.10}, shell, 0, recline);
  }
  if (random.chance(0.5)) bench.add(rounded_box({0.05, 0.16, 0.07}, 0.5), {0.26, 0, 0.12}, cover);  // an impact shield
  Carpenter foot{bench_on(seat, 0.22, across, 0.5 * base, seat.cushion_pitch_rad), CabinPart::kChildSeat, meshes};
  foot.add(rounded_box({0.19, 0.17, 0.5 * base}, 0.3), Eigen::Vector3d::Zero(), shell);
  return {bench.vehicle_from_bench * Eigen::Vector3d(0.11, 0, 0.10), recline, false};
}

ChildPlace add_rear_baby_seat(const SeatSetting& seat, Random& random, Meshes& meshes) {
  const CabinMaterial shell = fabric(random, 0.15, 0.9), cover = fabric(random, 0.10, 0.8);
  const double across = 0.015 * random.normal(), tilt = random.uniform(0.35, 0.60);  // the head end up
  const double base = random.uniform(0.06, 0.13);
  const Eigen::Vector3d semi(random.uniform(0.31, 0.36), random.uniform(0.19, 0.22), random.uniform(0.19, 0.23));
  const SeatAxes axes = axes_of(seat);
  // The bowl hangs with its open side up; +x of its frame is the head end, towards the dashboard.
  const Rigid3 pose{about_y(-tilt), on_cushion(axes, 0.30, across, base + semi.z() + 0.04)};
  meshes.push_back(placed(bowl(semi, -0.5 * M_PI, 0.05), pose, CabinPart::kChildSeat, shell));
  meshes.push_back(placed(bowl(0.92 * semi, -0.5 * M_PI, 0.05), pose, CabinPart::kChildSeat, cover));
  if (random.chance(0.5)) {  // a canopy over the head
    const double reach = random.uniform(0.9, 1.5);
    const auto canopy = grid_mesh(16, 8, [&](double u, double v) {
      const double around = M_PI * u, lift = reach * v;
      const Eigen::Vector3d rim(0.05, semi.y() * std::cos(around), semi.x() * 0.9 * std::sin(around));
      return Eigen::Vector3d(rim.x() + rim.z() * std::cos(lift), 1.03 * rim.y(), rim.z() * std::sin(lift) + 0.02);
    });
    meshes.push_back(placed(canopy, pose, CabinPart::kChildSeat, cover));
  }
  Carpenter foot{bench_on(seat, 0.28, across, 0.5 * base, seat.cushion_pitch_rad), CabinPart::kChildSeat, meshes};
  foot.add(rounded_box({0.24, 0.16, 0.5 * base + 0.03}, 0.3), Eigen::Vector3d::Zero(), shell);
  return {pose * Eigen::Vector3d(-0.10, 0, -0.55 * semi.z()), 0.5 * M_PI - tilt, true};
}

void add_objects(const SeatSetting& seat, Random& random, Meshes& meshes) {
  const double across = random.uniform(-0.10, 0.10), along = random.uniform(0.18, 0.30);
  Carpenter bench{bench_on(seat, along, across, 0, seat.cushion_pitch_rad), CabinPart::kObject, meshes};
  const auto cover = [&] { return fabric(random, 0.12, 0.95); };
  switch (random.below(5)) {
    case 0: {  // a suitcase
      const Eigen::Vector3d semi(random.uniform(0.09, 0.14), random.uniform(0.16, 0.22), random.uniform(0.15, 0.26));
      bench.add(rounded_box(semi, 0.2), {0, 0, semi.z()}, cover(), random.uniform(-0.5, 0.5));
      break;
    }
    case 1: {  // an open paper bag
      const double half = random.uniform(0.10, 0.15), wide = random.uniform(0.12, 0.19),
                   tall = random.uniform(0.15, 0.20);
      const CabinMaterial paper = cover();
      const double yaw = random.uniform(-0.5, 0.5);
      const Eigen::Quaterniond turned = about_z(yaw);
      for (const double side : {-1.0, 1.0}) {
        bench.add(rounded_box({0.006, wide, tall}, 0.2), turned * Eigen::Vector3d(side * half, 0, tall), paper, yaw);
        bench.add(rounded_box({half, 0.006, tall}, 0.2), turned * Eigen::Vector3d(0, side * wide, tall), paper, yaw);
      }
      bench.add(ellipsoid({0.8 * half, 0.8 * wide, 0.8 * tall}), {0, 0, 0.9 * tall}, cover());
      break;
    }
    case 2: {  // a pile of books
      double height = 0;
      const int books = 2 + random.below(5);
      for (int i = 0; i < books; ++i) {
        const double thick = random.uniform(0.012, 0.035);
        bench.add(rounded_box({random.uniform(0.08, 0.12), random.uniform(0.10, 0.16), thick}, 0.1),
                  {0, 0, height + thick}, cover(), 0.3 * random.normal());
        height += 2 * thick;
      }
      break;
    }
    case 3: {  // a ball
      const double radius = random.uniform(0.09, 0.14);
      bench.add(ellipsoid({radius, radius, radius}), {0, 0, radius}, cover());
      break;
    }
    default: {  // a bag that lies on its side, and bottles
      const Eigen::Vector3d semi(random.uniform(0.14, 0.20), random.uniform(0.12, 0.17), random.uniform(0.07, 0.12));
      bench.add(rounded_box(semi, 0.75), {0, 0, semi.z()}, cover(), random.uniform(-1.5, 1.5));
      bench.add(round_cone(0.20, 0.042, 0.02), {0.10, random.chance(0.5) ? 0.17 : -0.17, 0.045}, cover(), 0,
                0.5 * M_PI * random.below(2));
      break;
    }
  }
}

}  // namespace raybundle::held_out
