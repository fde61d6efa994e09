// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "figures.hpp"
#include "findings.hpp"
#include "raybundle/scene/parameter_names.hpp"
#include "raybundle/uncertainty/coverage.hpp"
#include "raybundle/uncertainty/frame_covariance.hpp"

namespace raybundle {
namespace {

constexpr double kMargin = 0.8;       // of the limit: sigmas are themselves known to some ten per cent
constexpr double kUnseenShare = 0.1;  // of a field, above which it counts as extrapolated
constexpr int kPlacesAcross = 40;

double degrees(double radians) { return radians * 180.0 / M_PI; }

Grade grade_of(const Requirement& requirement, double value) {
  if (!std::isfinite(value)) return Grade::kFail;
  if (requirement.quantity == Quantity::kCoverage) return value >= requirement.limit ? Grade::kPass : Grade::kFail;
  if (value > requirement.limit) return Grade::kFail;
  return requirement.quantity == Quantity::kRms || value <= kMargin * requirement.limit ? Grade::kPass
                                                                                        : Grade::kMarginal;
}

double baseline_sigma_by(const Covariance& covariance, const RigCamera& camera) {
  const Eigen::Vector3d along = camera.camera_from_rig.translation.normalized();
  const Eigen::Matrix3d of_translation = covariance.block(extrinsic_names(camera)).bottomRightCorner<3, 3>();
  return std::sqrt(along.dot(of_translation * along));
}

// With views like those that there are, sigmas fall with the root of their number.
std::string more_views(double value, double limit, int views) {
  const double more = views * ((value / limit) * (value / limit) - 1.0);
  return fmt::format(
      "views like these help slowly: it would take about {:.0f} more; the next best views do it with fewer",
      std::max(1.0, std::ceil(more)));
}

std::string fill_regions(const CameraCoverage& seen) {
  return fmt::format("hold the board at {} of camera {}: three views there, tilted by about 45°",
                     regions_in_words(seen.empty_regions), seen.camera);
}

// What is measured of one subject, in words and as a number.
struct Measured {
  double value = 0.0;
  std::string where;   // clauses after the value
  std::string advice;  // whatever the grade
  bool doubtful = false;
};

// By the corners' noise or by how the frames scatter, whichever is worse.
Figure worse_figure(const Requirement& requirement, const Subject& subject, const Calibration& calibration) {
  Figure figure = figure_of(requirement, subject, calibration, calibration.covariance, kPlacesAcross);
  if (!calibration.covariance_by_frame || subject.laser) return figure;
  Figure by_frame = figure_of(requirement, subject, calibration, *calibration.covariance_by_frame, kPlacesAcross);
  return by_frame.value > figure.value ? by_frame : figure;
}

Measured measured_projection(const Requirement& requirement, const Subject& subject, const CameraCoverage& seen,
                             const Calibration& calibration) {
  const Figure figure = worse_figure(requirement, subject, calibration);
  const Camera& camera = calibration.cameras[subject.first].camera;
  Measured measured{figure.value, ", largest at " + region_in_words(camera.size, figure.worst), {}, false};
  if (figure.unseen_share > kUnseenShare) {
    measured.where += fmt::format("; in {:.0f} % of the field no corner was seen, and nothing tests the lens there",
                                  100 * figure.unseen_share);
    measured.doubtful = true;
    if (!seen.empty_regions.empty()) measured.advice = fill_regions(seen);
  }
  if (requirement.field_rad && figure.reach_rad < 0.5 * *requirement.field_rad - 0.01) {
    measured.where += fmt::format("; the image has rays for only {:.0f} of the {:.0f}°", 2 * degrees(figure.reach_rad),
                                  degrees(*requirement.field_rad));
    measured.doubtful = true;
  }
  return measured;
}

Measured measured_depth(const Requirement& requirement, const Subject& subject, const Calibration& calibration) {
  const Figure figure = worse_figure(requirement, subject, calibration);
  if (!std::isfinite(figure.value)) {
    return {figure.value,
            subject.laser ? ": no beam's depth is stated there" : ": they see nothing together at that distance",
            subject.laser
                ? fmt::format("require it between {} and {} m", kStatedDepths_m.front(), kStatedDepths_m.back())
                : "require a distance at which their images overlap",
            false};
  }
  return {figure.value,
          subject.laser ? " or less for 95 % of the beams" : " or less in 95 % of the common field",
          {},
          false};
}

Measured measured(const Requirement& requirement, const Subject& subject, const CalibrationProblem& problem,
                  const CalibrationResult& result, const CameraCoverage& seen) {
  const Calibration& calibration = result.calibration;
  switch (requirement.quantity) {
    case Quantity::kProjection:
      return measured_projection(requirement, subject, seen, calibration);
    case Quantity::kDepth:
      return measured_depth(requirement, subject, calibration);
    case Quantity::kBaseline:
      return {baseline_sigma(calibration.cameras[subject.second], calibration), {}, {}, false};
    case Quantity::kCoverage:
      return {seen.image_share, " of the image",
              seen.empty_regions.empty() ? std::string("hold the board nearer to the edges of the image")
                                         : fill_regions(seen),
              false};
    case Quantity::kRms:
      break;
  }
  const auto named = std::ranges::find(problem.cameras, subject.name, &ProblemCamera::name);
  return {result.cameras[named - problem.cameras.begin()].rms_px, {}, {}, false};
}

const char* quantity_words(Quantity quantity) {
  static constexpr const char* kWords[] = {"rms ", "projections are uncertain by ", "depth is uncertain by ",
                                           "the baseline is uncertain by ", "corners were seen in "};
  return kWords[static_cast<int>(quantity)];
}

std::string advice_for(const Requirement& requirement, const Measured& found, int views) {
  if (!found.advice.empty() || !std::isfinite(found.value)) return found.advice;
  if (requirement.quantity == Quantity::kRms) {
    return "look at the worst views and at the residuals by angle: blur and a moving board make single views bad, a "
           "lens model that does not fit makes patterns";
  }
  return more_views(found.value, requirement.limit, views);
}

Judgement judged(const Requirement& requirement, const Subject& subject, const CalibrationProblem& problem,
                 const CalibrationResult& result, const CameraCoverage& seen) {
  const Measured found = measured(requirement, subject, problem, result, seen);
  Judgement judgement{requirement, subject.name, grade_of(requirement, found.value), found.value, {}, {}};
  const bool known = std::isfinite(found.value);
  judgement.reason = quantity_words(requirement.quantity) +
                     (known ? text_with_unit(requirement.quantity, found.value) : "an unknown amount") + found.where;
  int views = 0;
  for (const CameraSummary& camera : result.cameras) views = std::max(views, camera.views_used);
  if (judgement.grade != Grade::kPass || found.doubtful) judgement.advice = advice_for(requirement, found, views);
  if (found.doubtful && judgement.grade == Grade::kPass) judgement.grade = Grade::kMarginal;
  return judgement;
}

// A requirement that the result has nothing to hold against.
Judgement unjudged(const Requirement& requirement, const std::string& subject, const std::string& reason) {
  return {requirement, subject, Grade::kFail, std::nan(""), reason, "see the warnings"};
}

// Of cameras that are meant but were not calibrated.
std::vector<Judgement> of_missing_cameras(const Requirement& requirement, const CalibrationProblem& problem,
                                          const Calibration& calibration) {
  std::vector<Judgement> missing;
  for (const ProblemCamera& camera : problem.cameras) {
    const bool meant = requirement.camera.empty() || requirement.camera == camera.name;
    if (!meant || std::ranges::find(calibration.cameras, camera.name, &RigCamera::name) != calibration.cameras.end()) {
      continue;
    }
    missing.push_back(unjudged(requirement, camera.name, "the camera was not calibrated"));
  }
  return missing;
}

// What makes every sigma doubtful, whatever it says.
std::string doubt(const CalibrationResult& result) {
  if (result.termination != Termination::kConverged) return "the solve did not converge";
  const auto count = std::ranges::count_if(result.warnings, [&](const auto& w) { return w != result.scatter_warning; });
  if (count == 1) return "there is a warning";
  return count == 0 ? std::string() : fmt::format("there are {} warnings", count);
}

}  // namespace

double baseline_sigma(const RigCamera& camera, const Calibration& calibration) {
  return larger_sigma(calibration, [&](const Covariance& known) { return baseline_sigma_by(known, camera); });
}

const char* grade_name(Grade grade) {
  static constexpr const char* kNames[] = {"pass", "marginal", "fail"};
  return kNames[static_cast<int>(grade)];
}

Verdict verdict(const CalibrationProblem& problem, const CalibrationResult& result,
                const std::vector<Requirement>& requirements) {
  const std::vector<CameraCoverage> seen = coverage(problem, result);
  Verdict verdict;
  verdict.findings = findings(problem, result, seen);
  const std::string doubts = doubt(result);
  for (const Requirement& requirement : requirements) {
    const std::vector<Judgement> missing = of_missing_cameras(requirement, problem, result.calibration);
    std::vector<Judgement> all;
    for (const Subject& subject : subjects_of(requirement, result.calibration)) {
      Judgement judgement = judged(requirement, subject, problem, result, seen[subject.first]);
      if (judgement.grade == Grade::kPass && !doubts.empty()) {
        judgement.grade = Grade::kMarginal;
        judgement.reason += "; but " + doubts;
        judgement.advice = "mend what the warnings say, or make sure that it does not matter here";
      }
      all.push_back(std::move(judgement));
    }
    // Of a rig all around, only cameras that look at the same things are meant.
    const auto unknown = [](const Judgement& judgement) { return !std::isfinite(judgement.value); };
    if (requirement.quantity == Quantity::kDepth && !std::ranges::all_of(all, unknown)) std::erase_if(all, unknown);
    all.insert(all.begin(), missing.begin(), missing.end());
    if (all.empty()) all.push_back(unjudged(requirement, "the rig", "nothing in it tells this"));
    for (Judgement& judgement : all) {
      verdict.grade = std::max(verdict.grade.value_or(Grade::kPass), judgement.grade);
      verdict.judgements.push_back(std::move(judgement));
    }
  }
  return verdict;
}

}  // namespace raybundle
