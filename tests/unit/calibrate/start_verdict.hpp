// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "random_rig.hpp"
#include "raybundle/calibrate/calibrate.hpp"

namespace raybundle::testing {

/// A camera whose projection is known worse than this share of the image's longer side, root mean square over the
/// corners seen, is not determined: 13 px of 1280.
constexpr double kUndeterminedShare = 0.01;

/// What a solve that starts from the truth, with the right corners only, makes of a rig.
struct TruthStart {
  BundleState optimum;
  double cost = 0.0;
  /// Root mean square over the right corners' rays of what the covariance says of the projection [px], the rotation
  /// that the poses take up removed; infinite where the data do not see a direction.
  double projection_sigma_px = 0.0;
  bool determined = false;
};

TruthStart start_from_truth(const RandomRig& rig);

/// Whether another lens fits the right corners within three sigmas of what the truth's optimum does and yet projects
/// them elsewhere, the true lens itself or one of another focal length: the covariance at the optimum does not see it.
bool another_lens_fits(const RandomRig& rig, const TruthStart& truth);

enum class Verdict {
  kReached,             ///< the optimum that a start from the truth reaches, or a lower one
  kRefusedRightly,      ///< the data do not determine the camera, and it was said
  kElsewhere,           ///< a higher optimum, or the right corners of whole views left out
  kRefusedWrongly,      ///< the data determine the camera
  kUndeterminedAnswer,  ///< elsewhere where the data do not determine the camera: should have been refused
};

struct Judgement {
  Verdict verdict = Verdict::kReached;
  std::string why;            ///< in numbers; of a refusal its words
  double error_sigmas = 0.0;  ///< projection_error_px over projection_sigma_px
  double seconds = 0.0;       ///< processor time of calibrate()
  bool failed() const { return verdict != Verdict::kReached && verdict != Verdict::kRefusedRightly; }
};

/// Calibrates the rig from its observations alone and holds the answer against the truth's.
Judgement judge_start(const RandomRig& rig, const TruthStart& truth);

/// Whether a solve that goes on from a peer's answer, with the right corners only, reaches the optimum of the truth.
bool reaches(const RandomRig& rig, const TruthStart& truth, const std::optional<BundleState>& answer);

/// projection_difference_px of the true camera over the rays of the right corners.
double projection_error_px(const RandomRig& rig, const Camera& camera);

/// Half the sum of squared whitened residuals of the corners in use and of the priors; infinite when one of the corners
/// does not project.
double cost_of(const CalibrationProblem& problem, BundleState state);

}  // namespace raybundle::testing
