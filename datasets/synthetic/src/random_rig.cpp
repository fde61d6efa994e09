// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

#include "raybundle/geometry/error.hpp"
#include "raybundle/synthetic/random.hpp"
#include "raybundle/synthetic/rig.hpp"

namespace raybundle {
namespace {

constexpr double kRadian = M_PI / 180.0;

Camera random_camera(Random& random) {
  const ModelId model{random.below(static_cast<int>(Models::kSize))};
  static constexpr ImageSize kSizes[] = {{640, 480}, {752, 480}, {1280, 960}};
  const ImageSize size = kSizes[random.below(3)];
  return with_model(model, [&]<CameraModel M>() {
    const auto& example = M::kExamples[static_cast<std::size_t>(random.below(static_cast<int>(M::kExamples.size())))];
    Camera camera{model, size, Eigen::VectorXd(kParameterCount<M>)};
    for (int k = 0; k < kShapeSize<M>; ++k) camera.parameters[4 + k] = example.shape[k];
    // The example's field reaches the left and right border.
    const double edge[3] = {std::sin(0.95 * example.half_angle_rad), 0, std::cos(0.95 * example.half_angle_rad)};
    double plane[2] = {1, 0};
    M::plane_from_ray(camera.parameters.data() + 4, edge, plane);
    const double focal_px = 0.5 * size.width / std::abs(plane[0]);
    camera.parameters.head<4>() << focal_px, focal_px * random.uniform(0.995, 1.005),
        0.5 * (size.width - 1) + random.uniform(-8, 8), 0.5 * (size.height - 1) + random.uniform(-8, 8);
    return camera;
  });
}

Eigen::Quaterniond small_rotation(Random& random, double limit_rad) {
  const double x = random.uniform(-limit_rad, limit_rad), y = random.uniform(-limit_rad, limit_rad);
  const double z = random.uniform(-limit_rad, limit_rad);
  const Eigen::Vector3d vector(x, y, z);
  return Eigen::Quaterniond(Eigen::AngleAxisd(vector.norm(), vector.normalized()));
}

Emitter random_emitter(Random& random) {
  Emitter emitter;
  emitter.grid = {5 + random.below(13), 5 + random.below(15)};
  emitter.zero_order_row = 0.5 * (emitter.grid.rows - 1);
  emitter.zero_order_column = 0.5 * (emitter.grid.columns - 1);
  const bool even = emitter.grid.rows % 2 == 0 || emitter.grid.columns % 2 == 0;
  emitter.zero_order_power = even ? 0.0 : random.uniform(1.4, 2.5);
  emitter.wavelength_m = random.uniform(780e-9, 940e-9);
  emitter.lattice_turn_rad = random.uniform(8, 16) * kRadian;
  SpreadingLens lens;
  lens.index = random.uniform(1.5, 1.6);
  lens.radius_m = random.uniform(0.008, 0.011) * (lens.index - 1.0);
  lens.distance_m = random.uniform(0.010, 0.014);
  lens.offset_m = {random.uniform(-2e-5, 2e-5), random.uniform(-2e-5, 2e-5)};
  emitter.lens = lens;
  emitter.rig_from_emitter.translation = {random.uniform(0.04, 0.1), random.uniform(-0.02, 0.02), 0};
  emitter.rig_from_emitter.rotation = small_rotation(random, 2 * kRadian);
  const double columns_deg = random.uniform(50, 80);
  set_periods_from_field(emitter, kRadian * Eigen::Vector2d(columns_deg, random.uniform(0.7, 0.9) * columns_deg));
  return emitter;
}

}  // namespace

SimulatedRig random_rig(std::uint64_t seed) {
  Random random(seed, 0x7169);  // a stream that no frame uses
  SimulatedRig rig;
  const int cameras = 1 + random.below(2);
  for (int i = 0; i < cameras; ++i) {
    SimulatedCamera camera;
    camera.name = "camera" + std::to_string(i);
    camera.camera = random_camera(random);
    camera.used_half_angle_rad = 0.98 * max_angle_rad(camera.camera);
    if (i > 0) {
      camera.camera_from_rig.rotation = small_rotation(random, 3 * kRadian);
      camera.camera_from_rig.translation = {-random.uniform(0.06, 0.2), random.uniform(-0.01, 0.01), 0};
    }
    rig.cameras.push_back(camera);
  }
  rig.emitter = random_emitter(random);
  rig.board = simulated_chessboard(9, 6, random.uniform(0.05, 0.08));
  rig.board.print.sheet.low.array() -= 0.015;
  rig.board.print.sheet.high.array() += 0.015;
  rig.board.shape = {random.uniform(-0.001, 0.001), random.uniform(-0.001, 0.001), 0.0};
  rig.poses.min_distance_m = 0.35;
  rig.poses.whole_board = false;
  return rig;
}

}  // namespace raybundle
