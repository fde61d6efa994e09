// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "raybundle/scene/board_surface.hpp"
#include "raybundle/synthetic/rig.hpp"

namespace raybundle {

/// Poses of the board, as a person would hold it: each aims a place of the board at a beam, or at a place in the image
/// of a camera. Pose i depends on rig, seed and i only.
///
/// @throws Error(kNotEnoughData) when no pose within the rig's range shows the board
std::vector<Rigid3> random_board_poses(const SimulatedRig& rig, const BoardSurface& surface,
                                       const std::vector<EmittedBeam>& beams, int frames, std::uint64_t seed);

}  // namespace raybundle
