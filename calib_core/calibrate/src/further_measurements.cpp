// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "further_measurements.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "drag.hpp"
#include "laser_stage.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/threads.hpp"
#include "raybundle/uncertainty/corner_evidence.hpp"
#include "raybundle/uncertainty/covariance.hpp"
#include "raybundle/uncertainty/frame_covariance.hpp"
#include "raybundle/uncertainty/frame_repetition.hpp"
#include "stopwatch.hpp"
#include "stray_dots.hpp"
#include "survey_stage.hpp"

namespace raybundle {
namespace {

constexpr double kMuchScatter = 4.0;  // times a dot's stated sigma: speckle and ink make it twice as large

// Cameras, boards and beams in one bundle, from cameras and boards that are solved.
//
// @throws Error(kNotEnoughData) with nothing changed
void add_laser(const CalibrateOptions& options, const BundleOptions& bundle, double corner_scale,
               CalibrationProblem& problem, BundleState& state, CalibrationResult& result) {
  CalibrationResult with = result;
  LaserSolve solve;
  {
    const Stopwatch stopwatch(with.stages, "laser");
    solve = solve_with_dots(problem, state, corner_scale, options, bundle);
  }
  const std::optional<std::string> stray = judge_stray_dots(solve);
  {
    const Stopwatch stopwatch(with.stages, "uncertainty");
    solve.laser.parameters = drag_of(problem, state, solve.state, bundle, result.calibration.covariance);
    with.warnings.clear();  // those of the solve without dots; the covariance gives its own again
    fill_covariance(solve.problem, solve.state, solve.bundle, with);
    const RigCamera first{problem.cameras[0].name, solve.state.cameras[0], solve.state.camera_from_rig[0]};
    fill_uncertainty(solve, with.calibration.covariance, with.variance_factor, first, solve.pattern);
  }
  with.variance_factor *= result.variance_factor;
  with.calibration.laser = std::move(solve.pattern);
  with.termination = solve.summary.termination;
  with.iterations += solve.summary.iterations;
  if (solve.laser.origin_guessed) {
    with.warnings.push_back(
        "which beam is which is guessed: the labels may all be off by the same rows and columns; say which beam a dot "
        "belongs to (--anchor), or name the brightest or a missing beam");
  }
  if (const auto warning = drag_warning(solve.laser.parameters, "the laser's dots", "wrong labels")) {
    with.warnings.push_back(*warning);
  }
  if (stray) with.warnings.push_back(*stray);
  if (solve.laser.sigma_scale > kMuchScatter) {
    with.warnings.push_back(
        fmt::format("the laser's dots lie {:.0f} times as far from their beams as their sigmas say; are their labels "
                    "right, their u and v not exchanged, and the board flat?",
                    solve.laser.sigma_scale));
  }
  with.laser = std::move(solve.laser);
  problem = std::move(solve.problem);
  state = std::move(solve.state);
  result = std::move(with);
}

// What remains of the landmarks' joining for later.
struct JoinedSurvey {
  std::vector<Rigid3> target_from_local;  // of the targets that were added
  std::vector<std::string> warnings;      // besides those of the covariance, which is filled in again when dots join
};

// Landmarks join the bundle, in images of their own. What cannot be placed is told; without any the cameras remain.
//
// @param corner_scale  of the corners' residuals over the sigmas that they have; brought up to date
JoinedSurvey add_survey(const CalibrateOptions& options, const BundleOptions& bundle, double& corner_scale,
                        CalibrationProblem& problem, BundleState& state, CalibrationResult& result) {
  SurveySolve solve;
  {
    const Stopwatch stopwatch(result.stages, "survey");
    solve = solve_with_landmarks(problem, state, result.calibration.covariance, corner_scale, options, bundle);
  }
  if (solve.images.empty()) return {{}, solve.not_placed};
  const double before = result.variance_factor;
  SurveySummary survey{std::move(solve.images),
                       drag_of(problem, state, solve.state, bundle, result.calibration.covariance)};
  result.warnings.clear();  // those of the solve without landmarks; the covariance gives its own again
  {
    const Stopwatch stopwatch(result.stages, "uncertainty");
    fill_covariance(solve.problem, solve.state, bundle, result);
  }
  corner_scale = std::sqrt(result.variance_factor);
  result.variance_factor *= before;
  result.termination = solve.summary.termination;
  result.iterations += solve.summary.iterations;
  if (auto warning = drag_warning(survey.parameters, "the landmarks", "wrong names or coordinates")) {
    solve.not_placed.push_back(*warning);
  }
  result.survey = std::move(survey);
  problem = std::move(solve.problem);
  state = std::move(solve.state);
  return {std::move(solve.target_from_local), std::move(solve.not_placed)};
}

// The dots of a laser join the bundle. Without beams the cameras remain.
void try_laser(const CalibrateOptions& options, const BundleOptions& bundle, double corner_scale,
               CalibrationProblem& problem, BundleState& state, CalibrationResult& result) {
  if (!has_dots(problem)) {
    result.warnings.push_back(
        "no dot of the laser was found on a board; are the images with the laser on and off the same, or swapped?");
    return;
  }
  try {
    add_laser(options, bundle, corner_scale, problem, state, result);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kNotEnoughData) throw;
    result.warnings.push_back(std::string("the laser's beams could not be calibrated: ") + error.what());
  }
}

}  // namespace

void fill_covariance(const CalibrationProblem& problem, const BundleState& state, const BundleOptions& options,
                     CalibrationResult& result) {
  const std::vector<FrameInformation> frames = information_by_frame(problem, state, options);
  const ReducedInformation information = reduced_information(problem, state, options, frames);
  const CovarianceResult known = covariance(information);
  result.calibration.covariance = known.covariance;
  result.variance_factor = known.variance_factor;
  result.calibration.covariance_by_frame.reset();
  if (static_cast<int>(frames.size()) >= kFewestFrames) {
    const auto repeated = repeated_errors(problem, state, information.names, options.threads);
    result.calibration.covariance_by_frame = covariance_by_frame(information, frames, repeated, options.threads);
  }
  if (result.calibration.covariance_by_frame) {
    const auto warning = frame_scatter_warning(known.covariance, *result.calibration.covariance_by_frame,
                                               static_cast<int>(frames.size()));
    result.scatter_warning = warning.value_or("");
    if (warning) result.warnings.push_back(*warning);
  }
  if (known.weak_parameters.empty()) return;
  std::string weak;
  bool extrinsic = false;
  for (const std::string& name : known.weak_parameters) {
    weak += (weak.empty() ? "" : ", ") + name;
    extrinsic = extrinsic || name.find(".camera_from_rig.") != std::string::npos;
  }
  if (known.unseen && extrinsic) {
    throw Error(ErrorKind::kNotEnoughData, "the views do not determine " + weak +
                                               "; add frames in which all cameras see the board, at several tilts");
  }
  result.warnings.push_back("the views hardly tell these parameters apart: " + weak +
                            "; pixels may still be predicted well. Add views with the board tilted, near and far, and "
                            "in the corners of the image, or choose a model with fewer parameters");
}

void add_further_measurements(const CalibrateOptions& options, const BundleOptions& bundle, CalibrationProblem& problem,
                              BundleState& state, CalibrationResult& result,
                              std::vector<std::optional<CornerEvidence>>& evidence) {
  double corner_scale = std::sqrt(result.variance_factor);
  JoinedSurvey survey;
  if (problem.survey) survey = add_survey(options, bundle, corner_scale, problem, state, result);
  if (problem.laser) try_laser(options, bundle, corner_scale, problem, state, result);
  evidence.resize(problem.cameras.size());
  for_each_index(evidence.size(), options.threads,
                 [&](std::size_t c) { evidence[c] = corner_evidence(problem, state, static_cast<int>(c)); });
  std::ranges::copy(survey.warnings, std::back_inserter(result.warnings));
  if (!result.survey) return;
  fill_residuals(problem, state, survey.target_from_local, result.survey->images);
  leave_out_landmarks(survey.target_from_local.size(), problem, state);
}

}  // namespace raybundle
