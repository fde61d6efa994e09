// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/uncertainty/comparison.hpp"

namespace raybundle {

/// How the halves of one camera's frames agree when both are solved with another model.
struct ModelTrial {
  std::string camera;
  std::string model;
  double share_within = 0.0;  ///< as ProjectionDifference::share_within, by the larger sigmas
  double rms_px = 0.0;        ///< of both halves
  bool agrees = false;
};

/// The odd and the even frames solved apart, side by side.
struct CrossValidation {
  enum class Verdict {
    kAgree,          ///< the halves differ by no more than the corners' noise explains
    kAgreeByFrames,  ///< by more, but by no more than the sigmas by frames explain: corners err together
    kTiesDisagree,   ///< by more than either explains, but not where each camera is calibrated alone
    kModelError,     ///< by more than either explains, or another model fits much better
    kTooFewFrames,   ///< a half could not be solved, or not for a camera, whose name the words tell
  };
  Verdict verdict = Verdict::kAgree;
  std::optional<CalibrationComparison> by_corners;  ///< nothing when a half could not be solved
  std::optional<CalibrationComparison> by_frames;   ///< where both halves have enough frames
  std::vector<ModelTrial> trials;  ///< of cameras that the sigmas of corners do not explain, simplest first
  std::string words;               ///< the verdict in a sentence: which camera, what mends it
};

/// Solves the odd and the even frames of a problem apart and compares their projections at infinity. Where they differ
/// by more than kMostSummedSigmas over too much of the image, each camera is calibrated alone and, where that does not
/// mend it, with richer models of the list, of which the simplest that makes the halves agree is named. Dots take no
/// part.
///
/// @param whole  the result of all frames: views that it set aside take no part
CrossValidation cross_validate(const CalibrationProblem& problem, const CalibrationResult& whole,
                               const CalibrateOptions& options);

}  // namespace raybundle
