// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "beam_hits.hpp"

namespace raybundle {

/// Dots of different views that lie on one line.
struct HitLine {
  Line3 line;                    ///< pointing away from the projector
  std::vector<int> hits;         ///< indices into the hits, at most one for each view
  bool leans_on_source = false;  ///< too few hits for a line: it comes from where the other lines come from
};

/// Finds the lines on which dots of many views lie, without knowing where the projector is. First pairs of dots at
/// different ranges are tried until a few lines are beyond doubt; where these pass each other most closely is the
/// projector, about; seen from there the dots of one beam lie in nearly the same direction, which leaves few to try.
///
/// @return  none when no lines are beyond doubt; otherwise with 4 hits or more each, or 2 when it leans on the source;
///          every hit is on one line at most
std::vector<HitLine> lines_through_hits(const LaserScene& scene, const std::vector<BeamHit>& hits);

/// The line that fits hits best, each weighted by its covariance; hits that are not on it are dropped from the list.
void refit(const std::vector<BeamHit>& hits, HitLine& line);

}  // namespace raybundle
