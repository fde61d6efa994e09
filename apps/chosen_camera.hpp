// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "raybundle/scene/calibration.hpp"

namespace raybundle::apps {

/// The camera of that name; of an empty name the only one there is.
///
/// @throws Error(kBadInput) when there is none of that name, or no name and several cameras
const RigCamera& chosen_camera(const Calibration& calibration, const std::string& name);

}  // namespace raybundle::apps
