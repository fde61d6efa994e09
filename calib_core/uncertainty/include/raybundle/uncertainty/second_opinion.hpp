// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "raybundle/scene/problem.hpp"
#include "raybundle/scene/result.hpp"

namespace raybundle {

/// What another program makes of the corners that a solve used.
struct SecondOpinion {
  std::optional<Calibration> calibration;  ///< cameras and rig; evidence and covariance are the first opinion's
  Calibration counterpart;  ///< what it is to be held against: the first opinion, or its like by what mrcal knows
  double rms_px = 0.0;      ///< root of the mean squared distance
  std::string source;       ///< `mrcal, LENSMODEL_OPENCV8`
  std::string remark;       ///< how the counterpart differs from the first opinion; empty: not at all
  std::string why_not;      ///< without a calibration: the reason, one sentence
};

/// Solves for cameras, rig, board poses and board shape with mrcal's optimiser, from lenses some percent away and the
/// poses of the first opinion. Corners that the first opinion left out stay out. mrcal's boards bend along x and y, but
/// have no twist, and it knows no dots: where the first opinion has either, the counterpart is solved again without.
///
/// There is none for models that mrcal lacks, rigs of several models, boards that are no regular grid, parameters that
/// rules fix, or builds without mrcal.
SecondOpinion second_opinion(const CalibrationProblem& problem, const CalibrationResult& first);

}  // namespace raybundle
