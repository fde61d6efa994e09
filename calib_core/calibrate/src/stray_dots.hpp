// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "laser_stage.hpp"

namespace raybundle {

/// Judges how many of the dots on boards lie on a beam. Nearly all do where the projector stands still: a few spots on
/// the print, and dots that two beams explain, do not.
///
/// @return  a warning where more than a tenth do not, with the frames in which most do not
/// @throws Error(kNotEnoughData) when fewer than half do: what was found then is no projector, or one of several places
std::optional<std::string> judge_stray_dots(const LaserSolve& solve);

}  // namespace raybundle
