// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "raybundle/scene/problem.hpp"
#include "raybundle/scene/result.hpp"
#include "raybundle/uncertainty/requirements.hpp"

namespace raybundle {

/// A place of the board that would tell much.
struct NextView {
  int camera = 0;  ///< index of the calibration, whose image `text` speaks of
  int target = 0;
  Rigid3 rig_from_target;
  std::string text;     ///< how to hold the board
  double before = 0.0;  ///< the objective without this view, but with the ones listed before it
  double after = 0.0;   ///< and with it, as predicted
  /// Of the board in the image of each camera of the calibration; empty where it does not project.
  std::vector<std::vector<Eigen::Vector2d>> outlines;
};

struct NextViews {
  Quantity quantity = Quantity::kProjection;  ///< of the objective
  std::string objective;                      ///< what the views reduce, in words
  std::vector<NextView> views;                ///< each given those before it; empty when no board can be imagined
};

/// Of board poses all over the images, near and far, facing and tilted, those that reduce an uncertainty most: the
/// covariance with the normal equations of the imagined view added, its corners being as good as those there are. They
/// are chosen one after another by the root mean square over all places that count.
///
/// @param requirement  whose figure is to become smaller; nothing: the root mean square sigma of all projections at
///                     infinity. Of a requirement on other than projections and depths, also that. Depths of a
///                     laser's dots follow what the board would tell of the beams that meet it, the cameras staying as
///                     well known as they are.
NextViews next_best_views(const CalibrationProblem& problem, const CalibrationResult& result,
                          const std::optional<Requirement>& requirement, int count, int threads = 1);

}  // namespace raybundle
