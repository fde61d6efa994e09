// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "raybundle/scene/problem.hpp"
#include "raybundle/scene/result.hpp"

namespace raybundle {

/// Options of calibrate(); `for_each_option` is the one declaration that TOML, command line and docs walk.
struct CalibrateOptions {
  bool estimate_shape = true;       ///< bend and twist of the boards, where the data can carry it
  double robust_scale_sigma = 3.0;  ///< Cauchy loss of the first solve, in robust sigmas of the residuals
  double outlier_sigma = 5.0;       ///< corners beyond this many robust sigmas are removed, by id
  double tie_sigma = 3.0;           ///< [noise sigmas] by which a frame may fit worse tied than apart
  int max_iterations = 500;
  int threads = 2;

  /// Calls visit(name, unit, help, value) for every option.
  template <typename Options, typename Visitor>
  static void for_each_option(Options& options, Visitor&& visit) {
    visit("estimate_shape", "", "estimate bend and twist of flat boards when the data can carry it",
          options.estimate_shape);
    visit("robust_scale_sigma", "sigma", "scale of the Cauchy loss in the first solve", options.robust_scale_sigma);
    visit("outlier_sigma", "sigma", "corners with larger residuals are removed", options.outlier_sigma);
    visit("tie_sigma", "sigma", "a frame whose views fit worse together than apart by more does not tie the cameras",
          options.tie_sigma);
    visit("max_iterations", "", "of each solve", options.max_iterations);
    visit("threads", "", "worker threads; the result does not depend on them", options.threads);
  }
};

inline constexpr int kMostThreads = 256;

/// Refuses options that are not positive finite numbers, or too many threads.
///
/// @param where  they stand: file and line, or the command line
void check(const CalibrateOptions& options, const std::string& where = {});

/// Intrinsics, extrinsics, board poses and board shapes in one bundle adjustment, from observations alone.
/// See src/calibrate.cpp: the pipeline, step by step.
///
/// @throws Error(kBadInput) for options out of range, a problem that breaks an invariant, or one that mixes boards of
///         two sizes; Error(kNotEnoughData) when the views cannot determine the answer; Error(kSolveFailed) when the
///         solve breaks down
CalibrationResult calibrate(const CalibrationProblem& problem, const CalibrateOptions& options = {});

}  // namespace raybundle
