// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "draw.hpp"
#include "raybundle/bundle/bundle.hpp"
#include "raybundle/scene/problem.hpp"

namespace raybundle::testing {

/// How the boards of a rig are held.
enum class Holding { kOrdinary, kNear, kFar, kSteep, kRim, kParallel, kFewViews, kAlike };

/// A random camera with random views of a random board, and its truth.
struct RandomRig {
  CalibrationProblem problem;
  BundleState truth;  ///< wrong corners are marked kOutlier
  Holding holding = Holding::kOrdinary;
  double noise_px = 0.0;
  double outlier_share = 0.0;
  std::string story;  ///< in one line: lens, board, views
};

/// A lens of the model as real ones are: 40° to 200° across the longer side as far as the model reaches, the profile
/// rising over the whole field used, principal point up to 10 % off, pixels up to 10 % from square.
///
/// @param half_field_rad  set to the angle off the axis up to which the lens draws an image
Camera random_camera(ModelId model, Draw& draw, double& half_field_rad);

/// 5 to 60 views (3 or 4 of some rigs) of a board, near and far, steep, at the rim, partly hidden; noise of 0.05 to 0.5
/// px; up to 20 % of the corners wrong by 5 px to anywhere.
RandomRig random_rig(ModelId model, std::uint64_t seed);

}  // namespace raybundle::testing
