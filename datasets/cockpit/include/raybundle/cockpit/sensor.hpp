// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "raybundle/cockpit/cockpit.hpp"
#include "raybundle/scene/calibration.hpp"
#include "raybundle/synthetic/rig.hpp"

namespace raybundle {

/// A sensor in the overhead console, looking down and back at the passenger seat.
struct CabinSensor {
  SimulatedRig rig;                 ///< cameras and, for structured light, the emitter; board and poses are not used
  Rigid3 vehicle_from_rig;          ///< where it really is
  Rigid3 known_vehicle_from_rig;    ///< where whoever installed it believes it to be: all that a runtime may use
  double illuminator_W_m2 = 0.0;    ///< of the flood light between the cameras: on a surface 1 m before it, on axis
  bool automatic_exposure = false;  ///< each image's exposure follows its brightest pixels; else that of the sensor
};

/// A camera with a 2.6 mm lens and a grid of beams 6 cm beside it.
///
/// @param generator  whose sensors: focal lengths, periods of the grating and place in the console differ
/// @param seed       of the instance: tolerances of lens, mount and installation
/// @param grid       11x11 or any other
CabinSensor structured_light_sensor(CockpitGenerator generator, std::uint64_t seed, const LaserGrid& grid = {11, 11});

/// A pair of cameras with 2.1 mm lenses, of which 110° are used, and a flood light.
///
/// @param size  of the images: the same field at any
CabinSensor stereo_sensor(CockpitGenerator generator, std::uint64_t seed, const ImageSize& size = {128, 128});

/// What a good calibration of the sensor saves: its true cameras and beams; beams with sigmas of 0.3 mm and 0.3 mrad.
Calibration calibration_of(const CabinSensor& sensor);

}  // namespace raybundle
