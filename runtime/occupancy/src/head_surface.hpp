// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capped_scan.hpp"
#include "raybundle/occupancy/head.hpp"

namespace raybundle {

/// What the points say of the surface to which a head was fitted.
struct HeadSurface {
  double bend_off = 0.0;  ///< see Head; infinite when too few points tell
  double pierced = 0.0;   ///< see Head
};

/// Tells heads from what a fit lays an ellipsoid amid: the wings and tubs of child seats. Within its bounds on both
/// sides are the points of a plate, so that the mean square of their distances hardly shows it; that it is flat does.
HeadSurface surface_of(const CappedScan& capped, const Head& head, const HeadOptions& options);

}  // namespace raybundle
