// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "shapes.hpp"
#include "training.hpp"

namespace raybundle::training {
namespace {

// A point on a pad: flat in the middle, raised bolsters at the sides, sides and far edge bent down.
//
// along, across   -0.08 .. length, -1 .. 1
struct Pad {
  double length_m, half_width_m, bolster_m, skirt_m;

  Eigen::Vector3d at(double u, double v) const {  // along, across, out of the plane
    const double start = -0.08, bent = 0.88;      // shares of u: beyond, the far edge is bent down
    const double edge = 0.05;                     // radius of the edges [m]
    const double along = u < bent ? start + (length_m - edge - start) * u / bent
                                  : length_m - edge + edge * std::sin(0.5 * M_PI * (u - bent) / (1 - bent));
    const double drop =
        u < bent ? 0.0 : edge * (1 - std::cos(0.5 * M_PI * (u - bent) / (1 - bent))) + skirt_m * (u > 0.999);
    const double side = 2 * v - 1, flat = 0.52, side_bent = 0.9;
    const double width = std::min(std::abs(side) / side_bent, 1.0);
    const double rise =
        width > flat ? 0.5 * (1 - std::cos(M_PI * std::min(1.0, (width - flat) / (1 - flat) / 0.75))) : 0;
    const double side_drop = std::abs(side) > side_bent ? skirt_m * (std::abs(side) - side_bent) / (1 - side_bent) : 0;
    return {along, std::copysign(width, side) * half_width_m, bolster_m * rise * (1 - u * 0.3) - drop - side_drop};
  }
};

CabinMesh pad_mesh(const Pad& pad) {
  return grid_mesh(28, 20, [&](double u, double v) { return pad.at(v, u); });
}

// From pad coordinates along, across, out.
CabinMesh on_seat(CabinMesh mesh, const Eigen::Vector3d& bight, const Eigen::Vector3d& along,
                  const Eigen::Vector3d& out, const CabinMaterial& material) {
  Eigen::Matrix3d axes;
  axes << along, Eigen::Vector3d::UnitY(), out;
  for (Eigen::Vector3f& vertex : mesh.vertices) vertex = (bight + axes * vertex.cast<double>()).cast<float>();
  mesh.part = CabinPart::kSeat;
  mesh.material = material;
  return mesh;
}

void add_wall(Meshes& meshes, CabinPart part, const CabinMaterial& material, const Eigen::Vector3d& corner,
              const Eigen::Vector3d& first, const Eigen::Vector3d& second) {
  meshes.push_back(
      placed(grid_mesh(6, 6, [&](double u, double v) -> Eigen::Vector3d { return corner + u * first + v * second; }),
             {}, part, material));
}

}  // namespace

CabinMaterial cloth(Random& random, double low_albedo, double high_albedo) {
  CabinMaterial material;
  material.albedo = random.uniform(low_albedo, high_albedo);
  material.specular = random.chance(0.2) ? random.uniform(0.02, 0.1) : 0.0;
  material.contrast = random.uniform(0.1, 0.4);
  material.grain_m = random.uniform(0.006, 0.012);
  material.seed = static_cast<std::uint32_t>(random.below(1 << 30));
  return material;
}

void add_seat(const SeatSetting& seat, Random& random, Meshes& meshes) {
  const CabinMaterial cover = cloth(random, 0.10, 0.6);
  const SeatAxes axes = axes_of(seat);
  const double half_width = random.uniform(0.23, 0.275), bolster = random.uniform(0.012, 0.06);
  const Pad cushion{random.uniform(0.45, 0.54), half_width, bolster, 0.16};
  const Pad back{random.uniform(0.58, 0.68), half_width - 0.015, bolster + 0.01, 0.10};
  meshes.push_back(on_seat(pad_mesh(cushion), axes.bight, axes.cushion_forward, axes.cushion_normal, cover));
  meshes.push_back(on_seat(pad_mesh(back), axes.bight, axes.back_up, axes.back_normal, cover));
  // Its back side, and the headrest on two posts.
  const Rigid3 reclined{about_y(-seat.recline_rad), Eigen::Vector3d::Zero()};
  const auto on_back = [&](double up, double across, double out) -> Eigen::Vector3d {
    return axes.bight + up * axes.back_up + out * axes.back_normal + Eigen::Vector3d(0, across, 0);
  };
  meshes.push_back(placed(rounded_box({0.04, half_width - 0.03, 0.33}, 0.3),
                          {reclined.rotation, on_back(0.28, 0, -0.10)}, CabinPart::kSeat, cover));
  const double head = back.length_m + random.uniform(0.06, 0.17);
  meshes.push_back(
      placed(rounded_box({random.uniform(0.035, 0.065), random.uniform(0.10, 0.15), random.uniform(0.06, 0.11)}, 0.5),
             {reclined.rotation, on_back(head, 0, 0.0)}, CabinPart::kSeat, cover));
  CabinMaterial steel = cover;
  steel.albedo = 0.5;
  steel.specular = 0.3;
  for (const double across : {-0.06, 0.06}) {
    meshes.push_back(limb(on_back(back.length_m - 0.05, across, -0.02), on_back(head, across, -0.01), 0.007, 0.007,
                          CabinPart::kSeat, steel));
  }
}

void add_car(const CabinLayout& layout, Random& random, Meshes& meshes) {
  const CabinMaterial plastic = cloth(random, 0.08, 0.35), lining = cloth(random, 0.4, 0.7);
  CabinMaterial carpet = cloth(random, 0.06, 0.2);
  carpet.specular = 0;
  const double x = layout.dashboard_x_m, top = layout.dashboard_top_m, door = layout.door_y_m, floor = -0.30;
  const double driver_door = 2 * layout.middle_y_m - door;
  meshes.push_back(placed(swept({{x + 0.45, top + 0.02},
                                 {x + 0.15, top},
                                 {x + 0.04, top - 0.03},
                                 {x + 0.01, top - 0.07},
                                 {x, top - 0.12},
                                 {x + 0.015, top - 0.17},
                                 {x + 0.04, top - 0.25},
                                 {x + 0.08, top - 0.40},
                                 {x + 0.2, top - 0.50},
                                 {x + 0.38, floor + 0.1},
                                 {x + 0.30, floor}},
                                door, driver_door),
                          {}, CabinPart::kDashboard, plastic));
  add_wall(meshes, CabinPart::kCar, carpet, {-1.3, door, floor}, {x + 1.6, 0, 0}, {0, driver_door - door, 0});
  add_wall(meshes, CabinPart::kCar, lining, {-1.3, door, layout.roof_m}, {1.65, 0, 0}, {0, driver_door - door, 0});
  // Doors up to the windows, and the pillars between them.
  for (const double y : {door, driver_door}) {
    add_wall(meshes, CabinPart::kCar, plastic, {-1.3, y, floor}, {x + 1.6, 0, 0}, {0, 0, 0.42 - floor});
    add_wall(meshes, CabinPart::kCar, lining, {-0.42, y, 0.42}, {0.16, 0, 0}, {0, 0, layout.roof_m - 0.42});
  }
  meshes.push_back(placed(rounded_box({0.28, 0.035, 0.04}, 0.4),
                          {Eigen::Quaterniond::Identity(), {0.15, door + 0.03, 0.12}}, CabinPart::kCar, plastic));
  meshes.push_back(placed(rounded_box({0.55, 0.09, 0.16}, 0.25),
                          {Eigen::Quaterniond::Identity(), {0.15, layout.middle_y_m, -0.16}}, CabinPart::kCar,
                          plastic));
  // The driver's seat and the rear bench.
  const CabinMaterial cover = cloth(random, 0.15, 0.5);
  const double driver = 2 * layout.middle_y_m;
  meshes.push_back(
      placed(rounded_box({0.26, 0.25, 0.08}, 0.4), {about_y(-0.2), {0.12, driver, -0.14}}, CabinPart::kCar, cover));
  meshes.push_back(
      placed(rounded_box({0.07, 0.24, 0.33}, 0.4), {about_y(-0.4), {-0.27, driver, 0.20}}, CabinPart::kCar, cover));
  meshes.push_back(
      placed(rounded_box({0.05, 0.13, 0.09}, 0.5), {about_y(-0.4), {-0.42, driver, 0.63}}, CabinPart::kCar, cover));
  meshes.push_back(placed(rounded_box({0.25, 0.62, 0.10}, 0.3), {about_y(-0.15), {-0.85, layout.middle_y_m, -0.10}},
                          CabinPart::kCar, cover));
  meshes.push_back(placed(rounded_box({0.08, 0.62, 0.36}, 0.3), {about_y(-0.4), {-1.2, layout.middle_y_m, 0.25}},
                          CabinPart::kCar, cover));
}

}  // namespace raybundle::training
