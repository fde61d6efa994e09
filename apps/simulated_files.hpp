// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "raybundle/synthetic/simulate.hpp"
#include "simulated_board.hpp"

namespace raybundle::apps {

/// dataset.toml for the images of simulated_image().
///
/// @param laser    nullptr when there is none
/// @param command  how the data set was made
std::string dataset_text(const BoardedRig& boarded, const ProblemLaser* laser, const std::string& command);

/// Writes observations.json and, in truth/, calibration.json, observations.json and poses.json.
void write_simulation(const std::filesystem::path& folder, const Simulation& simulation, const std::string& command);

}  // namespace raybundle::apps
