// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "raybundle/scene/problem.hpp"
#include "raybundle/scene/result.hpp"
#include "raybundle/uncertainty/comparison.hpp"

namespace raybundle {

/// What another program makes of the corners that a solve used.
struct SecondOpinion {
  std::string source;  ///< `mrcal, LENSMODEL_OPENCV8`
  /// The first opinion, or its like by what mrcal knows, against this one.
  std::optional<CalibrationComparison> comparison = {};
  double rms_px = 0.0;  ///< root of the mean squared distance
  /// Of splines: rms by which they miss our lens when corners lie exactly where it projects them. It has been taken
  /// out.
  std::optional<double> approximation_px = {};
  std::string remark;   ///< what is to be known of the comparison
  std::string why_not;  ///< without a comparison: the reason, one clause
};

/// Whether this build can ask mrcal.
bool second_opinion_available();

/// Solves for cameras, rig, board poses and board shape with mrcal's optimiser, from the poses of the first opinion:
/// with the same lens model, where mrcal has it, from lenses some percent away; and with mrcal's splined lenses, which
/// stand for any central lens, from stereographic ones. Corners that the first opinion left out stay out. mrcal's
/// boards bend along x and y, but have no twist, and it knows no dots: where the first opinion has either, what is
/// compared is a solve of ours without. Splined lenses turn freely within their cameras, so only their projections are
/// compared.
///
/// There is none for boards that are no regular grid, parameters that rules fix, or builds without mrcal.
std::vector<SecondOpinion> second_opinions(const CalibrationProblem& given, const CalibrationResult& first);

}  // namespace raybundle
