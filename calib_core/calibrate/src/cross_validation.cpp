// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/calibrate/cross_validation.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "raybundle/bundle/parameters.hpp"
#include "raybundle/geometry/error.hpp"
#include "subproblem.hpp"

namespace raybundle {
namespace {

using Verdict = CrossValidation::Verdict;

struct Halves {
  CalibrationProblem odd, even;
};

// Every other of the frames in use, without views that were set aside, without dots and without landmarks.
Halves halves_of(const CalibrationProblem& problem, const CalibrationResult& whole) {
  std::set<int> frames;
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    if (whole.views[v].pose >= 0) frames.insert(problem.views[v].frame);
  }
  Halves halves{problem, problem};
  for (CalibrationProblem* half : {&halves.odd, &halves.even}) {
    half->views.clear();
    half->laser.reset();
    half->survey.reset();  // the halves would agree because they share it
  }
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    if (whole.views[v].pose < 0) continue;
    TargetView view = problem.views[v];
    view.dots.clear();
    const auto rank = std::distance(frames.begin(), frames.find(view.frame));
    (rank % 2 == 0 ? halves.odd : halves.even).views.push_back(view);
  }
  return halves;
}

struct Solved {
  CalibrationResult odd, even;

  double rms_px() const { return std::sqrt(0.5 * (odd.rms_px * odd.rms_px + even.rms_px * even.rms_px)); }
};

Solved solve(const Halves& halves, const CalibrateOptions& options) {
  return {calibrate(halves.odd, options), calibrate(halves.even, options)};
}

std::optional<CalibrationComparison> compare_by_frames(const Solved& solved) {
  const Calibration &odd = solved.odd.calibration, &even = solved.even.calibration;
  if (!odd.covariance_by_frame || !even.covariance_by_frame) return std::nullopt;
  return compare(odd, even, {.sigmas_from = SigmasFrom::kFrames});
}

// The camera alone, with a model. Another than its own brings its own start; rules that keep the start of the other one
// say nothing of it.
CalibrationProblem with_model_of(const CalibrationProblem& problem, int camera, ModelId model) {
  CalibrationProblem alone = select_cameras(problem, {camera}).problem;
  if (alone.cameras[0].model != model) {
    alone.cameras[0].model = model;
    alone.cameras[0].parameters.reset();
    CalibrationProblem lens_only;
    lens_only.cameras = alone.cameras;
    std::erase_if(alone.rules, [&](const ParameterRule& rule) {
      return rule.kind != ParameterRule::Kind::kFree && !rule.value && matches_any(rule, lens_only);
    });
  }
  std::erase_if(alone.rules, [&](const ParameterRule& rule) { return !matches_any(rule, alone); });
  return alone;
}

std::optional<ModelTrial> try_model(const Halves& halves, int camera, ModelId model, const CalibrateOptions& options) {
  ModelTrial trial{halves.odd.cameras[camera].name, std::string(model_name(model))};
  try {
    const Solved solved =
        solve({with_model_of(halves.odd, camera, model), with_model_of(halves.even, camera, model)}, options);
    trial.rms_px = solved.rms_px();
    trial.share_within = compare(solved.odd.calibration, solved.even.calibration).projections[0].share_within;
    if (const auto by_frames = compare_by_frames(solved)) {
      trial.share_within = std::max(trial.share_within, by_frames->projections[0].share_within);
    }
    trial.agrees = trial.share_within >= kLeastShareWithin;
  } catch (const Error&) {
    return std::nullopt;  // a model that cannot be solved for does not mend anything
  }
  return trial;
}

// Other models with at least as many parameters, fewest first.
std::vector<ModelId> richer_models(ModelId model) {
  std::vector<ModelId> richer;
  for (const std::string_view name : model_names()) {
    const ModelId other = *model_named(name);
    if (other != model && parameter_names(other).size() >= parameter_names(model).size()) richer.push_back(other);
  }
  std::ranges::stable_sort(richer, {}, [](ModelId other) { return parameter_names(other).size(); });
  return richer;
}

// The simplest model that makes a camera's halves agree and leaves residuals of at most this share of its own.
//
// @param own  the camera alone with its own model
std::optional<ModelTrial> mending_model(const Halves& halves, int camera, const std::optional<ModelTrial>& own,
                                        double most_residuals, const CalibrateOptions& options,
                                        CrossValidation& result) {
  for (const ModelId richer : richer_models(halves.odd.cameras[camera].model)) {
    auto trial = try_model(halves, camera, richer, options);
    if (!trial) continue;
    result.trials.push_back(*trial);
    if (trial->agrees && (!own || trial->rms_px <= most_residuals * own->rms_px)) return trial;
  }
  return std::nullopt;
}

// What the worst camera's halves do.
std::string share_text(const CalibrationComparison& comparison) {
  const auto& worst = *std::ranges::min_element(comparison.projections, {}, &ProjectionDifference::share_within);
  return fmt::format("camera {}'s are within {:g} summed sigmas over {:.0f} % of the image, {:.3f} px apart rms",
                     worst.camera, kMostSummedSigmas, 100 * worst.share_within, worst.rms_px);
}

const ProjectionDifference* of_camera(const CalibrationComparison& comparison, const std::string& camera) {
  const auto found = std::ranges::find(comparison.projections, camera, &ProjectionDifference::camera);
  return found == comparison.projections.end() ? nullptr : &*found;
}

// Why a camera's halves differ by more than the sigmas of its corners explain.
struct Cause {
  bool by_frames = false;             // those by frames explain it
  std::optional<ModelTrial> alone;    // the camera without the rig, where its halves agree then
  std::optional<ModelTrial> mending;  // with another model
};

// A lens model that does not fit makes frames disagree, too: where only the sigmas by frames explain the halves, a
// model that leaves much smaller residuals still tells that it is the model.
Cause cause_of(const Halves& halves, int camera, const CalibrateOptions& options, CrossValidation& result) {
  constexpr double kNoWorse = 1.02, kMuchBetter = 0.9;  // residuals over those of the model in question
  Cause cause;
  const std::string& name = halves.odd.cameras[camera].name;
  const ProjectionDifference* by_frames = result.by_frames ? of_camera(*result.by_frames, name) : nullptr;
  cause.by_frames = by_frames && by_frames->agrees();
  const auto own = try_model(halves, camera, halves.odd.cameras[camera].model, options);
  const bool of_rig = halves.odd.cameras.size() > 1;
  if (of_rig && !cause.by_frames && own && own->agrees) {
    cause.alone = own;
  } else {
    cause.mending = mending_model(halves, camera, own, cause.by_frames ? kMuchBetter : kNoWorse, options, result);
  }
  return cause;
}

void judge(const Halves& halves, const CalibrateOptions& options, CrossValidation& result) {
  if (result.by_corners->agrees()) {
    result.words = "odd and even frames agree: " + share_text(*result.by_corners);
    return;
  }
  std::string mended, alone;
  bool open = false;  // a camera of which no cause was found
  for (int c = 0; c < static_cast<int>(halves.odd.cameras.size()); ++c) {
    const std::string& camera = halves.odd.cameras[c].name;
    const ProjectionDifference* difference = of_camera(*result.by_corners, camera);
    if (!difference || difference->agrees()) continue;
    const Cause cause = cause_of(halves, c, options, result);
    open = open || !(cause.by_frames || cause.alone || cause.mending);
    if (cause.alone) {
      alone += fmt::format("; camera {}'s agree over {:.0f} % of the image when it is calibrated alone", camera,
                           100 * cause.alone->share_within);
    }
    if (cause.mending) {
      mended += fmt::format("; {} mends camera {} (its halves then agree over {:.0f} % of the image, rms {:.3f} px)",
                            cause.mending->model, camera, 100 * cause.mending->share_within, cause.mending->rms_px);
    }
  }
  if (open || !mended.empty()) {
    result.verdict = Verdict::kModelError;
    result.words =
        "model error: odd and even frames differ by more than noise explains: " + share_text(*result.by_corners) +
        mended + alone;
    if (open) {
      result.words +=
          "; where no model of the list mends it, look at the board (flat, of the stated size?), at focus, and at a "
          "shutter that rolls";
    }
  } else if (!alone.empty()) {
    result.verdict = Verdict::kTiesDisagree;
    result.words = "odd and even frames differ by more than noise explains: " + share_text(*result.by_corners) + alone +
                   ": the frames that tie the cameras disagree, as when they do not expose together; trigger them "
                   "together, or keep the board still until all have taken their image";
  } else {
    result.verdict = Verdict::kAgreeByFrames;
    result.words = "odd and even frames differ by more than the sigmas of the corners explain (" +
                   share_text(*result.by_corners) +
                   "), but by no more than those by frames do, and no other model fits much better: corners of a frame "
                   "err together";
  }
}

// Halves that agree say nothing of a camera that one of them could not calibrate.
void judge_missing(const Calibration& whole, CrossValidation& result) {
  std::vector<std::string> missing;
  for (const RigCamera& camera : whole.cameras) {
    if (!of_camera(*result.by_corners, camera.name)) missing.push_back(camera.name);
  }
  if (missing.empty()) return;
  if (result.verdict != Verdict::kModelError) result.verdict = Verdict::kTooFewFrames;
  result.words =
      fmt::format("camera {} could not be calibrated from the odd and from the even frames apart; of the others: {}",
                  fmt::join(missing, ", "), result.words);
}

CrossValidation not_compared(const std::string& words) {
  CrossValidation result;
  result.verdict = Verdict::kTooFewFrames;
  result.words = words;
  return result;
}

}  // namespace

CrossValidation cross_validate(const CalibrationProblem& problem, const CalibrationResult& whole,
                               const CalibrateOptions& options) {
  CrossValidation result;
  const Halves halves = halves_of(problem, whole);
  Solved solved;
  try {
    solved = solve(halves, options);
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::kIo) throw;
    return not_compared(std::string("the odd and the even frames could not be solved apart: ") + error.what());
  }
  try {
    result.by_corners = compare(solved.odd.calibration, solved.even.calibration);
    result.by_frames = compare_by_frames(solved);
  } catch (const Error& error) {
    return not_compared(std::string("the odd and the even frames could not be compared: ") + error.what());
  }
  judge(halves, options, result);
  judge_missing(whole.calibration, result);
  return result;
}

}  // namespace raybundle
