// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/next_view.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "board_candidates.hpp"
#include "figures.hpp"
#include "pose_information.hpp"
#include "raybundle/geometry/quantile.hpp"
#include "raybundle/uncertainty/coverage.hpp"

namespace raybundle {
namespace {

constexpr int kPlacesAcross = 12;  // at which the uncertainty is looked at, for hundreds of candidates
constexpr int kFewestCorners = 6;  // by which a camera ties a board to the rig

// Views of a board by all cameras that see enough of it.
std::vector<ViewData> imagined_views(const Calibration& calibration, int target, const Rigid3& rig_from_target,
                                     double sigma_px) {
  std::vector<ViewData> views;
  for (int c = 0; c < static_cast<int>(calibration.cameras.size()); ++c) {
    ViewData view = imagined_corners(calibration, c, target, rig_from_target, sigma_px);
    if (view.pixel.rows() >= kFewestCorners) views.push_back(std::move(view));
  }
  return views;
}

// (C^-1 + H)^-1 = C - C L (1 + L' C L)^-1 L' C for H = L L': no inverse of a covariance is formed.
Eigen::MatrixXd updated(const Eigen::MatrixXd& covariance, const Eigen::MatrixXd& information) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(information);
  const Eigen::MatrixXd root = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  const Eigen::MatrixXd across = covariance * root;
  Eigen::MatrixXd inner = root.transpose() * across;
  inner.diagonal().array() += 1.0;
  return covariance - across * inner.llt().solve(across.transpose());
}

// Of a corner, as the solve found it: its stated sigma and how far residuals exceed such ones.
double corner_sigma(const CalibrationProblem& problem, const CalibrationResult& result) {
  std::vector<double> sigmas;
  for (const TargetView& view : problem.views) {
    for (const Observation& observation : view.observations) sigmas.push_back(observation.sigma_px);
  }
  return median(sigmas) * std::sqrt(result.variance_factor);
}

// What the views are to reduce, for any covariance of the calibration's parameters.
struct Objective {
  const Calibration& calibration;
  std::optional<Requirement> requirement;
  std::vector<Subject> subjects;

  Objective(const Calibration& of, const std::optional<Requirement>& wanted) : calibration(of) {
    const bool movable = wanted && (wanted->quantity == Quantity::kProjection || wanted->quantity == Quantity::kDepth);
    if (!movable) return;
    requirement = wanted;
    subjects = subjects_of(*wanted, of);
    std::erase_if(subjects, &Subject::laser);
    if (subjects.empty()) requirement.reset();
  }

  double operator()(const Covariance& covariance) const {
    double worst = 0.0;
    for (const Subject& subject : subjects) {
      const double value = figure_of(*requirement, subject, calibration, covariance, kPlacesAcross).value;
      if (std::isfinite(value)) worst = std::max(worst, value);
    }
    return requirement ? worst : rms(covariance);
  }

  // Root mean square over all images.
  double rms(const Covariance& covariance) const {
    double sum = 0.0;
    int count = 0;
    for (const RigCamera& camera : calibration.cameras) {
      if (!camera.evidence) continue;
      const UncertaintyMap map =
          uncertainty_map(projection_uncertainty(camera, covariance), kInfinitelyFar, kPlacesAcross);
      for (const double sigma : map.sigma_px.reshaped()) {
        if (!std::isfinite(sigma)) continue;
        sum += sigma * sigma;
        ++count;
      }
    }
    return count > 0 ? std::sqrt(sum / count) : 0.0;
  }

  std::string words() const {
    return requirement ? "what '" + requirement->text + "' limits, at its worst"
                       : "the sigma of projections at infinity, root mean square over all images";
  }
};

// The flat board that most views show.
std::optional<int> usual_target(const CalibrationProblem& problem) {
  std::vector<int> views(problem.targets.size(), 0);
  for (const TargetView& view : problem.views) ++views[view.target];
  for (std::size_t t = 0; t < views.size(); ++t) {
    if (!problem.targets[t].flat()) views[t] = 0;
  }
  const auto most = std::ranges::max_element(views);
  if (most == views.end() || *most == 0) return std::nullopt;
  return static_cast<int>(most - views.begin());
}

}  // namespace

Covariance covariance_with_board(const Calibration& calibration, int target, const Rigid3& rig_from_target,
                                 double sigma_px) {
  const std::vector<ViewData> views = imagined_views(calibration, target, rig_from_target, sigma_px);
  Covariance covariance = calibration.covariance;
  if (views.empty() || covariance.names.empty()) return covariance;
  covariance.matrix = updated(covariance.matrix, pose_information(calibration, views, rig_from_target).information);
  return covariance;
}

NextViews next_best_views(const CalibrationProblem& problem, const CalibrationResult& result,
                          const std::optional<Requirement>& requirement, int count) {
  Calibration calibration = result.calibration;  // its covariance follows the views that have been chosen
  const Objective objective(calibration, requirement);
  NextViews next;
  if (objective.requirement) next.quantity = objective.requirement->quantity;
  next.objective = objective.words();
  const std::optional<int> target = usual_target(problem);
  if (!target) return next;
  const double sigma_px = corner_sigma(problem, result);
  const std::vector<CameraCoverage> seen = coverage(problem, result);
  std::vector<BoardCandidate> candidates;
  for (int c = 0; c < static_cast<int>(calibration.cameras.size()); ++c) {
    if (!calibration.cameras[c].evidence) continue;
    for (BoardCandidate& each : board_candidates(calibration, c, *target, seen[c]))
      candidates.push_back(std::move(each));
  }
  for (int k = 0; k < count && !candidates.empty(); ++k) {
    const double before = objective(calibration.covariance);
    const BoardCandidate* best = nullptr;
    Covariance with_best;
    double least = before;
    for (const BoardCandidate& candidate : candidates) {
      Covariance with = covariance_with_board(calibration, *target, candidate.rig_from_target, sigma_px);
      const double after = objective(with);
      if (!(after < least)) continue;
      best = &candidate;
      least = after;
      with_best = std::move(with);
    }
    if (!best) break;
    NextView view{best->camera, *target, best->rig_from_target, best->text, before, least, {}};
    for (const RigCamera& camera : calibration.cameras) {
      view.outlines.push_back(outline_in_image(camera, calibration.targets[*target].target, best->rig_from_target));
    }
    next.views.push_back(std::move(view));
    calibration.covariance = std::move(with_best);
  }
  return next;
}

}  // namespace raybundle
