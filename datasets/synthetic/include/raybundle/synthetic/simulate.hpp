// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "raybundle/scene/calibration.hpp"
#include "raybundle/scene/problem.hpp"
#include "raybundle/scene/result.hpp"
#include "raybundle/synthetic/rig.hpp"

namespace raybundle {

struct SimulateOptions {
  int frames = 60;
  std::uint64_t seed = 1;
  double corner_sigma_px = 0.1;  ///< of each coordinate; with 0 the observations are exact and state 0.1
  double dot_sigma_px = 0.1;
  bool labelled = true;   ///< dots carry their beam; else nothing tells, not even their order
  double missed = 0.0;    ///< share of the dots that are not found
  double spurious = 0.0;  ///< false dots on the board, over the true ones
  double warmer_K = 0.0;  ///< the emitter's temperature above the one of its wavelength
  int min_corners = 8;    ///< views with fewer are not made
};

/// What a rig would measure, and the truth behind it.
struct Simulation {
  CalibrationProblem problem;      ///< as measured: noisy, without start values
  CalibrationProblem exact;        ///< the same views, corners and dots in the same order, without noise, labelled
  Calibration truth;               ///< cameras, board with its bend, beams; no covariance
  std::vector<BoardPose> poses;    ///< one for each frame
  std::vector<EmittedBeam> beams;  ///< with power; truth.laser holds the labelled ones
};

/// Moves the board in front of the rig as a person would, and observes corners and dots. Poses depend on rig, seed and
/// frame only: neither noise nor the number of frames nor the laser's temperature changes them. The same rig and options
/// give the same bits.
///
/// @throws Error(kBadInput) for options out of range; Error(kNotEnoughData) when no pose within the rig's range shows
///         the board: names what to change
Simulation simulate(const SimulatedRig& rig, const SimulateOptions& options = {});

}  // namespace raybundle
