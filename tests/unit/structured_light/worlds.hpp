// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

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

}  // namespace raybundle::testing
