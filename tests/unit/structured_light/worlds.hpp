// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "cabin_scene.hpp"
#include "raybundle/structured_light/sensor_table.hpp"
#include "raybundle/synthetic/rig.hpp"

namespace raybundle::testing {

/// A sensor that is known exactly, but for the covariance that its beams state.
struct SensorWorld {
  SimulatedRig rig;
  std::vector<EmittedBeam> beams;
  RigCamera camera;
  Calibration calibration;
};

/// The 130° camera and its projector of the rig description, with a grid and a turn of the beams.
///
/// @param beam_sigma_m  of the beams' offsets; their slopes as well [rad]
inline SensorWorld sensor_world(const LaserGrid& grid, double turn_deg, double beam_sigma_m = 1e-4) {
  SensorWorld world;
  world.rig = read_rig(RAYBUNDLE_SOURCE_DIR "/datasets/rigs/rig_26mm_laser.toml");
  if (grid.rows != world.rig.emitter->grid.rows || grid.columns != world.rig.emitter->grid.columns) {
    set_grid(*world.rig.emitter, grid);
  }
  world.rig.emitter->lattice_turn_rad = turn_deg * M_PI / 180.0;
  world.beams = beams_of(*world.rig.emitter);
  world.camera = {world.rig.cameras[0].name, world.rig.cameras[0].camera, world.rig.cameras[0].camera_from_rig};
  world.calibration.cameras = {world.camera};
  LaserPattern laser{.grid = world.rig.emitter->grid, .beams = {}, .grating = {}};
  for (const EmittedBeam& beam : world.beams) {
    if (!beam.labelled()) continue;
    LaserBeam known{.row = beam.row, .column = beam.column, .line = {beam.line.at(0.6), beam.line.direction}};
    known.covariance = beam_sigma_m * beam_sigma_m * Eigen::Matrix4d::Identity();
    laser.beams.push_back(known);
  }
  world.calibration.laser = laser;
  return world;
}

/// What a grating emits at another wavelength; ln of it over that of the calibration.
inline std::vector<EmittedBeam> emitted_by(const LaserPattern& laser, double log_wavelength) {
  std::vector<EmittedBeam> beams;
  Grating grating = *laser.grating;
  grating.wavelength_scale = std::exp(log_wavelength);
  for (int b = 0; b < laser.grid.size(); ++b) {
    const int row = laser.grid.row(b), column = laser.grid.column(b);
    const double m = column - laser.zero_order_column, n = row - laser.zero_order_row;
    beams.push_back({row, column, *beam_of_order(grating, m, n), 1.0});
  }
  return beams;
}

/// The same camera beside a projector that is its grating's model, so that it is known how the wavelength moves beams.
inline SensorWorld grating_world(const LaserGrid& grid, double turn_deg, double beam_sigma_m = 1e-4) {
  SensorWorld world = sensor_world(grid, turn_deg, beam_sigma_m);
  Grating grating;
  grating.rig_from_projector.translation = {0.06, 0.003, -0.004};
  grating.rig_from_projector.rotation = Eigen::AngleAxisd(turn_deg * M_PI / 180.0, Eigen::Vector3d::UnitZ());
  grating.column_pitch = 1.4 / grid.columns;
  grating.row_pitch = 1.1 / grid.rows;
  LaserPattern& laser = *world.calibration.laser;
  laser.grating = grating;
  laser.zero_order_column = 0.5 * (grid.columns - 1);
  laser.zero_order_row = 0.5 * (grid.rows - 1);
  world.beams = emitted_by(laser, 0.0);
  laser.beams.clear();
  for (const EmittedBeam& beam : world.beams) {
    LaserBeam known{.row = beam.row, .column = beam.column, .line = {beam.line.at(0.6), beam.line.direction}};
    known.covariance = beam_sigma_m * beam_sigma_m * Eigen::Matrix4d::Identity();
    laser.beams.push_back(known);
  }
  return world;
}

}  // namespace raybundle::testing
