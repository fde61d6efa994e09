// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "raybundle/io/calibration_file.hpp"
#include "raybundle/scene/problem.hpp"
#include "raybundle/scene/result.hpp"
#include "raybundle/uncertainty/held_out_dots.hpp"
#include "raybundle/uncertainty/wavelength.hpp"

namespace raybundle::apps {

/// How the dots of a laser fared on boards that the calibration has not seen.
struct LaserVerdict {
  int dots = 0;  ///< on boards of known place
  std::vector<HeldOutDot> explained;
  double rms_px = 0.0;
  double median_px = 0.0;
  double limit_mm = 0.0;                         ///< of plane_mm(); 0: none
  std::optional<WavelengthEstimate> wavelength;  ///< of these dots, where the calibration has a grating

  /// Root mean square distance from the boards of the points between two depths [mm]; NaN without any.
  double plane_mm(double nearest_m = 0.0, double farthest_m = INFINITY) const;
  bool passed() const { return limit_mm <= 0.0 || plane_mm() <= limit_mm; }
};

/// Dots by the beams of the calibration, on the boards where their corners have put them.
LaserVerdict judge_laser(const Calibration& calibration, const CalibrationProblem& observed,
                         const CalibrationResult& placed);

void print_laser(const LaserVerdict& verdict);
nlohmann::ordered_json json_of(const LaserVerdict& verdict);

/// Writes the calibration with its beams where the wavelength that the dots show puts them.
///
/// @throws Error(kNotEnoughData) when they do not show it
void write_retuned(const std::string& path, const CalibrationFile& file, const std::optional<LaserVerdict>& verdict);

}  // namespace raybundle::apps
