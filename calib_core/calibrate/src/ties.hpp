// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/bundle/bundle.hpp"
#include "raybundle/calibrate/calibrate.hpp"

namespace raybundle {

/// What decides whether the cameras of a frame saw the board in one place.
struct TieRule {
  double share_kept = 0.25;     ///< of the frames tie in any case, the best ones
  bool wary = false;            ///< far worse than the best frames is another moment in any case
  bool unsynchronised = false;  ///< the cameras do not expose together, ties are worth little
};

/// Which views were left untied, and what that says of the rig.
struct TieReview {
  std::vector<SetAside> untied;  ///< views with a board pose of their own, and why
  bool doubtful = false;         ///< not even share_kept of the frames fit together as well as apart
  bool strict = false;           ///< the limit was tie_sigma itself: a smaller share_kept would change nothing
  bool changed = false;          ///< a tie has come or gone
  double typical_px = 0.0;       ///< rms of the corners in the median frame of those that tie
};

/// Decides anew, under the cameras as they are, in which frames the cameras saw the board in one place. A view that did
/// not gets a board pose of its own: it keeps its say about its camera but not about the rig. Views that fit again
/// are tied again.
///
/// @param settled  as BundleOptions, of the boards' poses that the state then has
TieReview review_ties(const CalibrationProblem& problem, BundleState& state, const CalibrateOptions& options,
                      const TieRule& rule, double settled = BundleOptions().settled);

}  // namespace raybundle
