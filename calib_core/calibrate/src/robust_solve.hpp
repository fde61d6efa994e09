// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "raybundle/bundle/bundle.hpp"
#include "raybundle/calibrate/calibrate.hpp"

namespace raybundle {

/// Of a corner's sigma: less noise than that is rounding.
inline constexpr double kExactNoise = 1e-3;

/// A plain solve's options, as calibrate() was asked.
BundleOptions bundle_options(const CalibrateOptions& options);

/// Robust standard deviation of each camera's whitened residuals per coordinate: the median distance over that of a
/// standard normal in two dimensions (1.1774), and that times the root of values per degree of freedom: the lens and
/// the poses fit a part of the noise, of views with few corners most of it. Where they fit a fifth of it or more, the root
/// of the sum of squares per degree of freedom, if that is larger. Infinite for a camera without used views.
std::vector<double> robust_sigmas(const CalibrationProblem& problem, const BundleState& state);

/// A state, and the solve that led to it.
struct SolvedState {
  BundleState state;
  std::vector<std::string> reasons;  ///< aligned with problem.views; why one has no pose
  BundleSummary summary;
};

/// Sum of the squared residuals of the priors, of the lens and by rules.
double prior_squares(const CalibrationProblem& problem, const BundleState& state);

/// Where corners are cut off that count as outliers under a noise [sigmas]: exact ones leave rounding only, and cut off
/// there they would leave it to the priors alone which state is the better.
double outlier_limit(const CalibrateOptions& options, double sigma);

/// Sum of the squared distances of all corners [sigmas], each cut off at a limit, and of the priors' residuals.
double all_squares(const CalibrationProblem& problem, const BundleState& state, double limit_sigmas);

/// Whether a state of a single camera is better than the one before: all its corners fit better, those beyond the limit
/// of outliers, under the smaller noise of both, counted as if they were there, and the priors with them: they are part
/// of what a solve makes small. Never one that did not solve or ends among its corners, unless the one before does.
///
/// @param priors_before  prior_squares() of the one before, where it was solved with other priors than the problem's
bool is_better(const CalibrationProblem& single, const SolvedState& after, const SolvedState& before,
               const CalibrateOptions& options, std::optional<double> priors_before = {});

/// The outlier rule in words, as the report prints it.
std::string outlier_rule(const CalibrateOptions& options);

/// Marks corners beyond options.outlier_sigma robust sigmas of their camera, from the residuals as they are, and sets
/// aside views of which more than half the corners are such; corners that fit again come back.
///
/// @param reasons  aligned with problem.views; set for the views that are set aside here
/// @return         whether any mark changed
bool mark_outliers(const CalibrationProblem& problem, BundleState& state, const CalibrateOptions& options,
                   std::vector<std::string>& reasons);

/// Minimises the Cauchy loss, its scale tightened with the residuals, so that wrong corners and views have no say: far
/// enough for the outlier rule, not to the last digit.
///
/// @param off_px  from where the state is, right corners may be so far off, even if they are few
BundleSummary solve_robustly(const CalibrationProblem& problem, BundleState& state, const CalibrateOptions& options,
                             double off_px = 0.0);

/// Gives views that were set aside a pose again if they fit the cameras as they are now: the pose of the board that
/// other cameras saw in the frame, or one of their own.
///
/// @return  whether a view has a pose again
bool give_second_chance(const CalibrationProblem& problem, BundleState& state, const CalibrateOptions& options,
                        std::vector<std::string>& reasons);

/// Plain least squares without the outliers, until solve and outlier rule agree.
///
/// @param solved  of a converged solve of the state as it is; without outliers anew nothing is left to do then
BundleSummary solve_without_outliers(const CalibrationProblem& problem, BundleState& state,
                                     const CalibrateOptions& options, bool estimate_shape,
                                     std::vector<std::string>& reasons, const BundleSummary& solved = {});

}  // namespace raybundle
