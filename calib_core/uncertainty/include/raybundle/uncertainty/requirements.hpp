// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "raybundle/uncertainty/projection_uncertainty.hpp"

namespace raybundle {

/// What a requirement limits.
enum class Quantity {
  kRms,         ///< [px] of the corners of each camera
  kProjection,  ///< [px] largest sigma of a projection, over a field and at a range
  kDepth,       ///< [m] sigma of the depth of stereo points, and of laser dots where there is a laser
  kBaseline,    ///< [m] sigma of the distance between the first camera and each other one
  kCoverage     ///< [share] of the image in which corners were seen
};

/// A demand on a calibration, in the words of the person who makes it.
struct Requirement {
  std::string text;  ///< as it was given
  Quantity quantity = Quantity::kRms;
  double limit = 0.0;                    ///< in the quantity's unit; a share is at least, all others at most
  double range_m = kInfinitelyFar;       ///< of projections and depths
  std::optional<double> field_rad = {};  ///< whole angle of the cone about the axis; nothing: the whole image
  std::string camera = {};               ///< the one that is meant; empty: all
};

/// How to write requirements, in a few lines for --help and messages.
std::string requirement_help();

/// Reads "QUANTITY LIMIT [at DISTANCE] [over ANGLE deg] [for CAMERA]", as in "depth 20 mm at 1 m" or
/// "projection 0.2 px over 110 deg".
///
/// @throws Error(kBadInput) with one sentence that says which word is not understood and which ones are
Requirement requirement_from_text(std::string_view text);

/// A value with the unit that people use for the quantity: "0.21 px", "18.4 mm", "85 %".
std::string text_with_unit(Quantity quantity, double value);

}  // namespace raybundle
