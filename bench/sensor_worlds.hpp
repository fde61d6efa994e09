// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/structured_light/sensor_table.hpp"
#include "raybundle/synthetic/simulate.hpp"

namespace raybundle::bench {

/// A simulated sensor: the truth, and what our own calibration of it knows.
struct SensorInUse {
  SimulatedRig rig;
  std::vector<EmittedBeam> beams;  ///< true
  RigCamera camera;                ///< true
  SensorTable table;               ///< of the calibration
};

/// Calibrates the 130° camera and its projector from 60 poses of a board, corners and dots to 0.1 px.
inline SensorInUse calibrated_sensor(const LaserGrid& grid, double turn_deg, const SensorRange& range,
                                     std::uint64_t seed = 7) {
  SensorInUse sensor;
  sensor.rig = read_rig(RAYBUNDLE_SOURCE_DIR "/datasets/rigs/rig_26mm_laser.toml");
  Emitter& emitter = *sensor.rig.emitter;
  if (grid.rows != emitter.grid.rows || grid.columns != emitter.grid.columns) set_grid(emitter, grid);
  emitter.lattice_turn_rad = turn_deg * M_PI / 180.0;
  sensor.beams = beams_of(emitter);
  sensor.camera = {sensor.rig.cameras[0].name, sensor.rig.cameras[0].camera, sensor.rig.cameras[0].camera_from_rig};
  const Simulation simulation = simulate(sensor.rig, {.frames = 60, .seed = seed, .labelled = true});
  const CalibrationResult result = calibrate(simulation.problem);
  sensor.table = sensor_table(result.calibration, "", range, "a simulation");
  return sensor;
}

}  // namespace raybundle::bench
