// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "raybundle/scene/problem.hpp"

namespace raybundle {

/// What observations.json holds. The format: docs/formats/observations.md.
struct ObservationsFile {
  CalibrationProblem problem;                  ///< without start values and rules; it has passed check()
  std::vector<std::optional<ModelId>> models;  ///< aligned with problem.cameras; those that the file names
};

/// The text of observations.json, one line for each view. Start values and rules are not written.
std::string text_from_observations(const ObservationsFile& file);

/// Reads the text back.
///
/// @param name  of the file, for messages
/// @throws Error(kBadInput) `name:line: ...` naming the key
ObservationsFile observations_from_text(std::string_view text, const std::string& name);

/// Writes observations.json, whole or not at all.
void write_observations(const std::filesystem::path& path, const ObservationsFile& file);

/// Reads observations.json.
///
/// @throws Error(kIo) when it cannot be read; otherwise as observations_from_text
ObservationsFile read_observations(const std::filesystem::path& path);

}  // namespace raybundle
