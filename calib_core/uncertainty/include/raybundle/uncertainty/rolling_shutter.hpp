// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/scene/problem.hpp"
#include "raybundle/scene/result.hpp"

namespace raybundle {

/// How much better one view fits when each row of its image has a time of its own: the board's pose then moves with a
/// constant velocity from the first row to the last. Root mean square distances, for the degrees of freedom that are
/// left.
struct RowTiming {
  int view = 0;
  double rms_px = 0.0;      ///< with one pose for all rows
  double by_rows_px = 0.0;  ///< with a velocity
  double otherwise_px =
      0.0;                ///< the best that anything else leaves: a time for each column, a bend and a lens of its own
  double sweep_px = 0.0;  ///< motion of the board in the image between the first row and the last, median corner

  /// Whether the velocity explains what neither chance nor anything else does: an F test at kRowTimingSigmas, and less
  /// than kRowTimingShare of what the best other explanation leaves.
  bool rolling = false;
};

/// Of a normal distribution, so that of 1000 still views at most one, with independent errors, passes the F test.
inline constexpr double kRowTimingSigmas = 3.1;
/// Of rms: half of chi2. Errors of lens and board fit rows hardly better than columns.
inline constexpr double kRowTimingShare = 0.7;

/// One entry for each view of the camera with enough corners to tell, by linear least squares at the solution.
///
/// @param camera  index of CalibrationProblem::cameras
std::vector<RowTiming> row_timings(const CalibrationProblem& problem, const CalibrationResult& result, int camera);

}  // namespace raybundle
