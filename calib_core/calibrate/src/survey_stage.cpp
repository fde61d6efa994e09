// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "survey_stage.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>

#include "raybundle/calibrate/lens_prior.hpp"
#include "raybundle/calibrate/survey.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/uncertainty/corner_evidence.hpp"
#include "subproblem.hpp"

namespace raybundle {
namespace {

constexpr double kGrossShare = 0.1;  // of the image's longer side: no lens that a few boards have shown is off by more

/// The rig as a calibration by which images can be placed.
Calibration calibration_of(const CalibrationProblem& problem, const BundleState& state, const Covariance& known) {
  Calibration calibration;
  for (int c = 0; c < static_cast<int>(problem.cameras.size()); ++c) {
    calibration.cameras.push_back(
        {problem.cameras[c].name, state.cameras[c], state.camera_from_rig[c], corner_evidence(problem, state, c)});
  }
  calibration.covariance = known;
  return calibration;
}

/// Every camera in every image, by itself: one that cannot be placed costs nobody else.
std::vector<SurveyImage> place_images(const Calibration& calibration, const Survey& survey,
                                      std::vector<std::string>& not_placed) {
  std::map<std::pair<std::string, std::string>, std::vector<Sighting>> parts;  // by image and camera
  const bool one_camera = calibration.cameras.size() == 1;
  for (const Sighting& sighting : survey.sightings) {
    const std::string camera = sighting.camera.empty() && one_camera ? calibration.cameras[0].name : sighting.camera;
    parts[{sighting.image, camera}].push_back(sighting);
  }
  Survey part{survey.landmarks, {}, survey.sighting_sigma_px};
  std::vector<SurveyImage> images;
  for (auto& [place, sightings] : parts) {
    const auto& [image, camera] = place;
    const auto found = std::ranges::find(calibration.cameras, camera, &RigCamera::name);
    if (found == calibration.cameras.end()) {
      not_placed.push_back(
          fmt::format("the landmarks in {} are left out: camera '{}' is not calibrated", image, camera));
      continue;
    }
    std::ranges::sort(sightings, {}, &Sighting::landmark);  // the bits do not depend on the order of the table
    part.sightings = std::move(sightings);
    try {
      PlacedImages placed = check_survey(calibration, *found, part);
      std::ranges::move(placed.images, std::back_inserter(images));
      for (const std::string& why : placed.not_placed) {
        not_placed.push_back(fmt::format("the landmarks in {} are left out: {}", image, why));
      }
    } catch (const Error& error) {
      not_placed.push_back(fmt::format("the landmarks in {} are left out: {}", image, error.what()));
    }
  }
  return images;
}

/// A surveyed landmark's index, and how many sightings of it were used to place images.
struct SeenLandmark {
  int index = 0;
  int used = 0;
};

std::map<std::string, SeenLandmark> seen_landmarks(const Survey& survey, const std::vector<SurveyImage>& images) {
  std::map<std::string, SeenLandmark> landmarks;
  for (std::size_t i = 0; i < survey.landmarks.size(); ++i) {
    landmarks[survey.landmarks[i].name].index = static_cast<int>(i);
  }
  for (const SurveyImage& image : images) {
    for (const LandmarkResidual& seen : image.landmarks) landmarks.at(seen.landmark).used += seen.used;
  }
  return landmarks;
}

/// The images of one moment as a frame, with the landmarks that they show as its target. The target's frame is the
/// rig's as it was placed, which keeps the digits of landmarks kilometres from their origin.
///
/// @return  target_from_local
Rigid3 add_frame(const std::vector<const SurveyImage*>& images, const Survey& survey,
                 const std::map<std::string, SeenLandmark>& landmarks, CalibrationProblem& problem,
                 BundleState& state) {
  const auto camera_of = [&](const SurveyImage& image) {
    const auto found = std::ranges::find(problem.cameras, image.camera, &ProblemCamera::name);
    return static_cast<int>(found - problem.cameras.begin());
  };
  // A camera that sees directions only does not know where the rig is.
  const SurveyImage& best = **std::ranges::max_element(images, {}, [](const SurveyImage* image) {
    return std::pair(!std::isnan(image->pose_sigma[3]),
                     std::ranges::count(image->landmarks, true, &LandmarkResidual::used));
  });
  Rigid3 rig_from_local = state.camera_from_rig[camera_of(best)].inverse() * best.camera_from_local;

  const int frame = static_cast<int>(problem.frames.size()), target_index = static_cast<int>(problem.targets.size());
  problem.frames.push_back(best.image);
  std::set<int> shown;
  for (const SurveyImage* image : images) {
    for (const LandmarkResidual& seen : image->landmarks) shown.insert(landmarks.at(seen.landmark).index);
  }
  Target target{best.image, {}, {}};
  for (const int i : shown) {
    const Landmark& landmark = survey.landmarks[i];
    const Eigen::Vector3d x = landmark.infinitely_far ? Eigen::Vector3d(rig_from_local.rotation * landmark.x_in_local)
                                                      : rig_from_local * landmark.x_in_local;
    target.points.push_back({i, x, landmark.infinitely_far});
  }
  for (const SurveyImage* image : images) {
    TargetView view{camera_of(*image), frame, target_index, {}, image->image, {}};
    std::vector<ObservationFate> fates;
    for (const LandmarkResidual& seen : image->landmarks) {
      // What is off as the lens is known now may fit when it is known better, but not from anywhere.
      const ImageSize size = problem.cameras[view.camera].size;
      const bool gross = seen.residual_px.norm() > kGrossShare * std::max(size.width, size.height);
      fates.push_back(gross ? ObservationFate::kOutlier : ObservationFate::kUsed);
      const SeenLandmark& landmark = landmarks.at(seen.landmark);
      const double sighting_variance = std::pow(survey.sighting_sigma_px, 2);
      const double of_landmark = std::pow(seen.own_sigma_px, 2) - sighting_variance;
      const double variance = sighting_variance + std::max(1, landmark.used) * of_landmark;
      view.observations.push_back({seen.pixel, std::sqrt(variance), landmark.index});
    }
    problem.views.push_back(std::move(view));
    state.fates.push_back(std::move(fates));
    state.pose_of_view.push_back(static_cast<int>(state.poses.size()));
  }
  state.poses.push_back({frame, target_index, Rigid3{}});
  state.shapes.emplace_back();
  problem.targets.push_back(std::move(target));
  return rig_from_local;
}

/// Whether a view's sightings hold its pose: four points do, or two directions and no point. Fewer than half of them
/// agree by chance.
bool hold_a_pose(const CalibrationProblem& problem, const TargetView& view, const std::vector<ObservationFate>& fates) {
  int points = 0, directions = 0;
  for (std::size_t i = 0; i < fates.size(); ++i) {
    if (fates[i] != ObservationFate::kUsed) continue;
    const bool far = problem.targets[view.target].find(view.observations[i].point_id)->infinitely_far;
    ++(far ? directions : points);
  }
  const bool most = 2 * (points + directions) >= static_cast<int>(fates.size());
  return most && (points >= 4 || (points == 0 && directions >= 2));
}

/// Whether the lens reaches a landmark. Its polynomials go on beyond where it ends, and would be bent to fit what lies
/// behind the camera.
bool is_in_sight(const CalibrationProblem& problem, const BundleState& state, int view, std::size_t sighting) {
  const TargetView& seen = problem.views[view];
  const Rigid3 from_target = camera_from_target(problem, state, view);
  const TargetPoint& point = *problem.targets[seen.target].find(seen.observations[sighting].point_id);
  const Eigen::Vector3d x = point.infinitely_far ? Eigen::Vector3d(from_target.rotation * point.x_in_target)
                                                 : from_target * point.x_in_target;
  return pixel_from_ray(state.cameras[seen.camera], x).has_value();
}

/// Marks sightings that are off by more than the limit, and sets images aside that keep too few. False when no mark
/// changed.
///
/// @param placed  as the added views and their observations
bool mark_outliers(const CalibrationProblem& problem, const std::vector<SurveyImage>& placed, BundleState& state) {
  constexpr double kOutlierSigmas = 4.0;
  const std::vector<std::vector<ObservationFate>> before = state.fates;
  const std::size_t first_view = problem.views.size() - placed.size();
  for (std::size_t v = first_view; v < problem.views.size(); ++v) {
    if (state.pose_of_view[v] < 0) continue;
    const std::vector<Eigen::Vector2d> residuals = view_residuals(problem, state, static_cast<int>(v));
    for (std::size_t i = 0; i < residuals.size(); ++i) {
      const double sigmas = residuals[i].norm() / placed[v - first_view].landmarks[i].own_sigma_px;
      state.fates[v][i] = !is_in_sight(problem, state, static_cast<int>(v), i) ? ObservationFate::kUnprojectable
                          : sigmas <= kOutlierSigmas                           ? ObservationFate::kUsed
                                                                               : ObservationFate::kOutlier;
    }
    if (hold_a_pose(problem, problem.views[v], state.fates[v])) continue;
    state.pose_of_view[v] = -1;
    std::ranges::fill(state.fates[v], ObservationFate::kViewSetAside);
  }
  return state.fates != before;
}

/// First with a robust loss, then least squares while sightings come and go.
BundleSummary solve_all(const CalibrationProblem& problem, const std::vector<SurveyImage>& placed,
                        const CalibrateOptions& options, const BundleOptions& bundle, BundleState& state) {
  constexpr int kMaxRounds = 8;
  BundleOptions plain = bundle;
  plain.threads = options.threads;
  plain.max_iterations = options.max_iterations;
  BundleOptions robust = plain;
  robust.robust_scale_sigma = options.robust_scale_sigma;
  BundleSummary summary = solve_bundle(problem, state, robust);
  for (int round = 0; round < kMaxRounds && summary.termination != Termination::kFailed; ++round) {
    if (!mark_outliers(problem, placed, state) && round > 0) break;
    summary = solve_bundle(problem, state, plain);
  }
  return summary;
}

void tell_images_set_aside(std::size_t first_view, SurveySolve& solve) {
  for (std::size_t v = first_view; v < solve.problem.views.size(); ++v) {
    if (solve.state.pose_of_view[v] >= 0) continue;
    const TargetView& view = solve.problem.views[v];
    const std::string& camera = solve.problem.cameras[view.camera].name;
    std::erase_if(solve.images, [&](const SurveyImage& i) { return i.image == view.image && i.camera == camera; });
    solve.not_placed.push_back("the landmarks in " + view.image + " are left out: too few of them fit camera " +
                               camera + "; are names and coordinates right?");
  }
}

}  // namespace

SurveySolve solve_with_landmarks(const CalibrationProblem& problem, const BundleState& cameras, const Covariance& known,
                                 double corner_scale, const CalibrateOptions& options, const BundleOptions& bundle) {
  SurveySolve solve{problem, cameras, {}, {}, {}, {}};
  const Survey& survey = *problem.survey;
  solve.images = place_images(calibration_of(problem, cameras, known), survey, solve.not_placed);
  if (solve.images.empty()) return solve;
  scale_corners(solve.problem, corner_scale);
  weigh_lens_priors(solve.problem, solve.state);
  const std::map<std::string, SeenLandmark> landmarks = seen_landmarks(survey, solve.images);
  std::map<std::string, std::vector<const SurveyImage*>> moments;  // in the order of solve.images
  for (const SurveyImage& image : solve.images) moments[image.image].push_back(&image);
  for (const auto& [moment, images] : moments) {
    solve.target_from_local.push_back(add_frame(images, survey, landmarks, solve.problem, solve.state));
  }
  mark_projectable(solve.problem, solve.state);
  solve.summary = solve_all(solve.problem, solve.images, options, bundle, solve.state);
  if (solve.summary.termination == Termination::kFailed) {
    throw Error(ErrorKind::kSolveFailed, "the bundle adjustment with the landmarks broke down: " +
                                             solve.summary.message + "; calibrate without them to get the cameras");
  }
  tell_images_set_aside(problem.views.size(), solve);
  return solve;
}

void fill_residuals(const CalibrationProblem& problem, const BundleState& state,
                    const std::vector<Rigid3>& target_from_local, std::vector<SurveyImage>& images) {
  const std::size_t first_target = problem.targets.size() - target_from_local.size();
  for (SurveyImage& image : images) {
    const auto view = std::ranges::find_if(problem.views, [&](const TargetView& other) {
      return other.target >= static_cast<int>(first_target) && other.image == image.image &&
             problem.cameras[other.camera].name == image.camera;
    });
    const int index = static_cast<int>(view - problem.views.begin());
    const Rigid3 moved = camera_from_target(problem, state, index);
    const std::vector<Eigen::Vector2d> residuals = view_residuals(problem, state, index);
    image.camera_from_local = moved * target_from_local[view->target - first_target];
    for (std::size_t i = 0; i < residuals.size(); ++i) {
      LandmarkResidual& landmark = image.landmarks[i];
      const TargetPoint& point = *problem.targets[view->target].find(view->observations[i].point_id);
      landmark.residual_px = residuals[i];
      landmark.used = state.fates[index][i] == ObservationFate::kUsed;
      landmark.sigma_px = landmark.own_sigma_px;
      landmark.sigmas = residuals[i].norm() / landmark.sigma_px;
      if (!point.infinitely_far) landmark.range_m = (moved * point.x_in_target).norm();
    }
    sum_up(image);
  }
}

void leave_out_landmarks(std::size_t targets, CalibrationProblem& problem, BundleState& state) {
  problem.targets.resize(problem.targets.size() - targets);
  problem.frames.resize(problem.frames.size() - targets);
  std::erase_if(problem.views, [&](const TargetView& v) { return v.target >= std::ssize(problem.targets); });
  state.shapes.resize(problem.targets.size());
  state.fates.resize(problem.views.size());
  state.pose_of_view.resize(problem.views.size());
  if (!state.dot_fates.empty()) state.dot_fates.resize(problem.views.size());
}

}  // namespace raybundle
