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
  double rms_px = 0.0;        ///< with one pose for all rows
  double by_rows_px = 0.0;    ///< with a velocity
  double otherwise_px = 0.0;  ///< the better of a time for each column and a bend of its own

  bool rows = false;  ///< a time for each row explains what chance does not, and better than both
  bool columns =
      false;  ///< a time for each column explains what chance does not, and better than rows: no camera does so
};

/// Of a normal distribution, so that of 1000 still views at most one, with independent errors, passes the F test.
inline constexpr double kRowTimingSigmas = 3.1;
/// Twice the logarithm by which one explanation has to be likelier than another: 20 times.
inline constexpr double kRowTimingGain = 6.0;

/// Whether views say that the shutter rolls. Errors of lens and board are smooth, too, and where they are what the
/// residuals show, columns explain as many views as rows do: at least three views, and four times as many as columns.
bool is_rolling(const std::vector<RowTiming>& timings);

/// One entry for each view of the camera with enough corners to tell, by linear least squares at the solution.
///
/// @param camera  index of CalibrationProblem::cameras
std::vector<RowTiming> row_timings(const CalibrationProblem& problem, const CalibrationResult& result, int camera);

}  // namespace raybundle
