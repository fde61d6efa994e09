// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/cockpit/sensor.hpp"

#include <cmath>

#include "raybundle/synthetic/random.hpp"
#include "shapes.hpp"

namespace raybundle {
namespace {

constexpr double kRadian = M_PI / 180.0;

// What differs between the two car makers.
struct Mounting {
  Eigen::Vector3d position, aim;  ///< [vehicle frame]
  double roll_rad;                ///< of the camera about its axis, upright being 0
};
constexpr double kPlaceSigma_m = 0.003, kTurnSigma_rad = 0.6 * kRadian;        // of mounting
constexpr double kKnownSigma_m = 0.001, kKnownTurnSigma_rad = 0.06 * kRadian;  // of measuring where it is mounted

Eigen::Vector3d normal3(Random& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return {x, y, z};
}

Rigid3 jittered(const Rigid3& pose, double sigma_m, double sigma_rad, Random& random) {
  Eigen::Matrix<double, 6, 1> motion;
  motion << sigma_rad * normal3(random), sigma_m * normal3(random);
  return perturbed(pose, motion);
}

Rigid3 looking_at(const Mounting& mounting) {
  Eigen::Matrix3d axes;
  axes.col(2) = (mounting.aim - mounting.position).normalized();
  axes.col(0) = axes.col(2).cross(Eigen::Vector3d::UnitZ()).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return {Eigen::Quaterniond(axes) * about_z(mounting.roll_rad), mounting.position};
}

void mount(CabinSensor& sensor, const Mounting& mounting, Random& random) {
  sensor.vehicle_from_rig = jittered(looking_at(mounting), kPlaceSigma_m, kTurnSigma_rad, random);
  sensor.known_vehicle_from_rig = jittered(sensor.vehicle_from_rig, kKnownSigma_m, kKnownTurnSigma_rad, random);
}

// The consoles of several cars of one maker.
Mounting in_some_car(Mounting mounting, Random& random) {
  constexpr double kPlace_m = 0.02, kAim_m = 0.03, kRoll_rad = 3 * kRadian;
  const auto within = [&](double most) {
    const double x = random.uniform(-most, most), y = random.uniform(-most, most), z = random.uniform(-most, most);
    return Eigen::Vector3d(x, y, z);
  };
  mounting.position += within(kPlace_m);
  mounting.aim += within(kAim_m);
  mounting.roll_rad += random.uniform(-kRoll_rad, kRoll_rad);
  return mounting;
}

// A lens of the Kannala-Brandt model; no two are alike.
SimulatedCamera camera_of(const char* name, const ImageSize& size, double focal_px, double half_angle_rad,
                          Random& random) {
  SimulatedCamera camera;
  camera.name = name;
  camera.camera = start_camera(*model_named("kannala_brandt"), size, focal_px);
  Eigen::VectorXd& p = camera.camera.parameters;
  const double scale = size.height / 480.0;
  p[0] *= 1 + 0.004 * random.normal();
  p[1] = p[0] * (1 + 0.001 * random.normal());
  p[2] += 3 * scale * random.normal();
  p[3] += 3 * scale * random.normal();
  const double typical[] = {-0.016, 0.004, -0.002, 0.0003};
  for (int k = 0; k < 4; ++k) p[4 + k] = typical[k] * (1 + 0.15 * random.normal());
  camera.used_half_angle_rad = half_angle_rad;
  return camera;
}

}  // namespace

CabinSensor structured_light_sensor(CockpitGenerator generator, std::uint64_t seed, const LaserGrid& grid) {
  const bool training = generator == CockpitGenerator::kTraining;
  Random random(seed, training ? 101 : 102);
  CabinSensor sensor;
  SimulatedCamera camera = camera_of("camera", {640, 480}, training ? 282.0 : 268.0, 70 * kRadian, random);
  camera.sensor.lens_blur_px = training ? 0.55 : 0.65;
  camera.sensor.vignetting = 4.0;
  camera.sensor.exposure = 2.5;
  sensor.rig.cameras.push_back(camera);
  Emitter emitter;
  emitter.grid = grid;
  emitter.lattice_turn_rad = (training ? 12.0 : 13.5) * kRadian;
  emitter.lens = SpreadingLens{.radius_m = training ? 0.00465 : 0.0050,
                               .index = 1.517,
                               .distance_m = 0.012,
                               .thickness_m = 0.0015,
                               .offset_m = 15e-6 * Eigen::Vector2d(random.normal(), random.normal())};
  emitter.zero_order_power = 1.6;
  set_grid(emitter, grid);  // even ones have no order zero
  set_periods_from_field(emitter, kRadian * (training ? Eigen::Vector2d(90, 70) : Eigen::Vector2d(86, 72)));
  emitter.speckle_contrast = 0.05;
  const Rigid3 beside{Eigen::Quaterniond::Identity(), {training ? 0.06 : 0.062, 0.003, -0.004}};
  emitter.rig_from_emitter = jittered(beside, 0.0005, 0.8 * kRadian, random);
  sensor.rig.emitter = emitter;
  mount(sensor,
        training ? in_some_car({{0.46, 0.34, 0.88}, {0.13, 0.00, 0.24}, 0.0}, random)
                 : Mounting{{0.48, 0.31, 0.90}, {0.16, -0.02, 0.22}, 4 * kRadian},
        random);
  return sensor;
}

CabinSensor stereo_sensor(CockpitGenerator generator, std::uint64_t seed, const ImageSize& size) {
  const bool training = generator == CockpitGenerator::kTraining;
  Random random(seed, training ? 201 : 202);
  CabinSensor sensor;
  // The used field fills the image's height.
  const double focal_px = (training ? 1.0 : 1.02) * size.height / (110 * kRadian);
  for (const char* name : {"left", "right"}) {
    SimulatedCamera camera = camera_of(name, size, focal_px, 55 * kRadian, random);
    camera.sensor.lens_blur_px = 0.6 * std::max(0.6, size.height / 480.0);
    camera.sensor.vignetting = training ? 7.0 : 6.0;
    sensor.rig.cameras.push_back(camera);
  }
  const Rigid3 right{Eigen::Quaterniond::Identity(), {training ? -0.12 : -0.10, 0, 0}};
  sensor.rig.cameras[1].camera_from_rig = jittered(right, 0.0005, 0.5 * kRadian, random);
  sensor.automatic_exposure = true;
  sensor.illuminator_W_m2 = training ? 6.0 : 7.0;
  mount(sensor,
        training ? in_some_car({{0.46, 0.33, 0.87}, {0.14, 0.00, 0.22}, 0.0}, random)
                 : Mounting{{0.49, 0.30, 0.88}, {0.17, -0.01, 0.21}, 4 * kRadian},
        random);
  return sensor;
}

Calibration calibration_of(const CabinSensor& sensor) {
  constexpr double kSigma = 3e-4, kNearest_m = 0.25, kMiddle_m = 0.7, kFarthest_m = 1.3;
  constexpr int kHits = 60;
  Calibration calibration;
  for (const SimulatedCamera& camera : sensor.rig.cameras) {
    calibration.cameras.push_back({camera.name, camera.camera, camera.camera_from_rig});
  }
  if (!sensor.rig.emitter) return calibration;
  const Emitter& emitter = *sensor.rig.emitter;
  LaserPattern pattern{emitter.grid, {}, std::nullopt, emitter.zero_order_row, emitter.zero_order_column};
  for (const EmittedBeam& emitted : beams_of(emitter)) {
    if (!emitted.labelled()) continue;
    LaserBeam beam{emitted.row, emitted.column, {emitted.line.at(kMiddle_m), emitted.line.direction}};
    beam.covariance = kSigma * kSigma * Eigen::Matrix4d::Identity();
    beam.hits = kHits;
    beam.nearest_hit_m = kNearest_m;
    beam.farthest_hit_m = kFarthest_m;
    pattern.beams.push_back(beam);
  }
  calibration.laser = pattern;
  return calibration;
}

}  // namespace raybundle
