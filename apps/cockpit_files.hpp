// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "raybundle/cockpit/cockpit.hpp"
#include "raybundle/cockpit/sensor.hpp"

namespace raybundle::apps {

/// What `simulate-cockpit` writes beside images: docs/formats/cockpit.md.
nlohmann::ordered_json json_from_layout(const CabinLayout& layout);
nlohmann::ordered_json json_from_truth(const CockpitTruth& truth);

/// vehicle.toml of whoever installs the sensor: docs/formats/occupancy.md.
std::string vehicle_toml(const CabinLayout& layout, const CabinSensor& sensor);

std::string cockpit_frame_name(int scene, int frame);  ///< SSSSS_FFF, which its images begin with
std::string vehicle_file_name(int scene);              ///< SSSSS_vehicle.toml

/// Removes images and vehicles of a former run that this one has not written again, and says so: they would be taken
/// for some of its own.
///
/// @param scenes  those of this run
void remove_former_files(const std::filesystem::path& folder, const nlohmann::ordered_json& scenes);

}  // namespace raybundle::apps
