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
  int boards = 0;    ///< of known place
  int dots = 0;      ///< in views whose board's place is known
  int expected = 0;  ///< of those, that lie on the boards where there are beams for them
  std::vector<HeldOutDot> explained;
  double rms_px = 0.0;
  double median_px = 0.0;
  double limit_mm = 0.0;   ///< of plane_mm(); 0: none
  double min_share = 0.0;  ///< of the expected dots: so many have to belong to a beam
  /// Whether the beams may be those at the wavelength that the dots show; points of the old ones are then not judged.
  bool retuned = false;
  /// Of these dots, where the calibration has a grating and its beams at that wavelength explain them.
  std::optional<WavelengthEstimate> wavelength;
  int explained_retuned = 0;  ///< dots, by the beams at that wavelength

  /// Root mean square distance from the boards of the points between two depths [mm]; NaN without any.
  double plane_mm(double nearest_m = 0.0, double farthest_m = INFINITY) const;
  bool drifted() const;      ///< whether the wavelength is plainly another than the calibration's
  bool enough_dots() const;  ///< whether so many belong to a beam that these are the laser's beams at all
  bool passed() const { return enough_dots() && (retuned || limit_mm <= 0.0 || plane_mm() <= limit_mm); }
};

/// What a laser has to reach, besides its dots being there.
struct LaserGate {
  double max_plane_mm = 0.0;  ///< rms of the points from the boards; 0: no gate
  double min_share = 0.5;     ///< of the dots on boards: so many have to belong to a beam
};

/// Dots by the beams of the calibration, on the boards where their corners have put them.
LaserVerdict judge_laser(const Calibration& calibration, const CalibrationProblem& observed,
                         const CalibrationResult& placed, const LaserGate& gate);

void print_laser(const LaserVerdict& verdict);

/// Why a laser did not pass, in one line.
std::string why_failed(const LaserVerdict& verdict);

nlohmann::ordered_json json_of(const LaserVerdict& verdict);

/// Writes the calibration with its beams where the wavelength that the dots show puts them, and says so.
///
/// @throws Error(kNotEnoughData) when they do not show one at which the beams explain them
void write_retuned(const std::string& path, const CalibrationFile& file, const std::optional<LaserVerdict>& verdict);

}  // namespace raybundle::apps
