// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "raybundle/io/provenance.hpp"
#include "raybundle/scene/calibration.hpp"
#include "raybundle/scene/problem.hpp"
#include "raybundle/scene/result.hpp"

namespace raybundle {

/// What calibration.json holds. The format: docs/formats/calibration.md, docs/schemas/calibration.schema.json.
struct CalibrationFile {
  Calibration calibration;
  double rms_px = 0.0;                   ///< over all cameras
  double variance_factor = 1.0;          ///< the covariance has been multiplied by it
  std::vector<CameraSummary> summaries;  ///< aligned with calibration.cameras, or empty
  Provenance provenance;
};

/// What a result leaves to be saved; cameras of the problem that could not be calibrated are not in it.
CalibrationFile calibration_file(const CalibrationProblem& problem, const CalibrationResult& result,
                                 const Provenance& provenance = {});

/// The text of calibration.json. Every number is written with the digits that bring back the same bits.
///
/// @throws Error(kBadInput) when a number is not finite, sizes do not agree, or the text could not be read back, as of
///         beams that are not sorted; nothing is made up
std::string text_from_calibration(const CalibrationFile& file);

/// Reads the text back and replays its self-test: the pixels that the writer computed must come out again.
///
/// @param name  of the file, for messages
/// @throws Error(kBadInput) `name:line: ...` naming the key
CalibrationFile calibration_from_text(std::string_view text, const std::string& name);

/// Writes calibration.json, whole or not at all.
void write_calibration(const std::filesystem::path& path, const CalibrationFile& file);

/// Reads calibration.json.
///
/// @throws Error(kIo) when it cannot be read; otherwise as calibration_from_text
CalibrationFile read_calibration(const std::filesystem::path& path);

}  // namespace raybundle
