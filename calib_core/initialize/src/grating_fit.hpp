// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "raybundle/scene/laser.hpp"

namespace raybundle {

/// A line and the order that makes it.
struct OrderedLine {
  double m = 0.0;
  double n = 0.0;
  Line3 line;
};

struct GratingFit {
  Grating grating;
  double rms_rad = 0.0;  ///< angle between lines and model, as seen from the projector at the lines' points
};

/// The grating whose beams come nearest to the lines, by Levenberg-Marquardt from a lattice without a lens. The
/// wavelength scale stays one: it is what later changes are measured against.
///
/// @return  nothing with too few lines to tell, or when the lines do not spread over both orders
std::optional<GratingFit> fit_grating(const std::vector<OrderedLine>& lines);

}  // namespace raybundle
