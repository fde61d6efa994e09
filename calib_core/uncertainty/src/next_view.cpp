// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/next_view.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "beam_knowledge.hpp"
#include "board_candidates.hpp"
#include "figures.hpp"
#include "image_sigmas.hpp"
#include "imagined_board.hpp"
#include "raybundle/geometry/quantile.hpp"
#include "raybundle/geometry/threads.hpp"
#include "raybundle/uncertainty/coverage.hpp"
#include "updated_covariance.hpp"

namespace raybundle {
namespace {

constexpr int kPlacesAcross = 12;  // at which the uncertainty is looked at, for hundreds of candidates

// Of a corner of each camera of the calibration, as the solve found it: its stated sigma, how much noise its camera has
// against the others, and how far residuals exceed such ones.
std::vector<double> corner_sigmas(const CalibrationProblem& problem, const CalibrationResult& result) {
  std::vector<double> sigmas;
  for (const TargetView& view : problem.views) {
    for (const Observation& observation : view.observations) sigmas.push_back(observation.sigma_px);
  }
  const double usual_px = median(sigmas) * std::sqrt(result.variance_factor);
  std::vector<double> of_cameras;
  for (const RigCamera& camera : result.calibration.cameras) {
    const auto named = std::ranges::find(problem.cameras, camera.name, &ProblemCamera::name);
    of_cameras.push_back(usual_px * result.cameras[named - problem.cameras.begin()].sigma_scale);
  }
  return of_cameras;
}

// What is known of the cameras and, where a laser's depth is required, of its beams.
struct Knowledge {
  Covariance parameters;
  BeamMatrices beams;
};

// What views add to it, as U' H U, so that it adds up.
struct Information {
  Eigen::MatrixXd of_parameters;
  BeamMatrices of_beams;

  Information& operator+=(const Information& other) {
    if (of_parameters.size() == 0) of_parameters.setZero(other.of_parameters.rows(), other.of_parameters.cols());
    of_parameters += other.of_parameters;
    of_beams.resize(other.of_beams.size(), Eigen::Matrix4d::Zero());
    for (std::size_t b = 0; b < of_beams.size(); ++b) of_beams[b] += other.of_beams[b];
    return *this;
  }
};

// What is known without any of the views, and its roots U.
struct Start {
  Knowledge known;
  Eigen::MatrixXd root;
  BeamMatrices beam_roots;

  explicit Start(const Calibration& calibration)
      : known{calibration.covariance, calibration.laser ? stated_beams(calibration) : BeamMatrices{}},
        root(root_of(known.parameters.matrix)) {
    for (const Eigen::Matrix4d& beam : known.beams) beam_roots.emplace_back(root_of(beam));
  }

  Knowledge with(const Information& added) const {
    Knowledge result = known;
    if (added.of_parameters.size() > 0) result.parameters.matrix = updated(root, added.of_parameters);
    for (std::size_t b = 0; b < added.of_beams.size(); ++b) {
      if (!added.of_beams[b].isZero(0.0)) result.beams[b] = updated(beam_roots[b], added.of_beams[b]);
    }
    return result;
  }
};

// What the views are to reduce, whatever is known.
struct Objective {
  const Calibration& calibration;
  std::optional<Requirement> requirement;
  std::vector<Subject> subjects;
  std::vector<ImageSigmas> images;  // at infinity, without a requirement

  Objective(const Calibration& of, const std::optional<Requirement>& wanted) : calibration(of) {
    choose_subjects(wanted);
    if (requirement) return;
    for (const RigCamera& camera : calibration.cameras) {
      if (camera.evidence) images.emplace_back(camera, calibration.covariance, kPlacesAcross);
    }
  }

  void choose_subjects(const std::optional<Requirement>& wanted) {
    const bool movable = wanted && (wanted->quantity == Quantity::kProjection || wanted->quantity == Quantity::kDepth);
    if (!movable) return;
    requirement = wanted;
    subjects = subjects_of(*wanted, calibration);
    if (subjects.empty()) requirement.reset();
  }

  bool needs_beams() const { return std::ranges::any_of(subjects, &Subject::laser); }
  bool needs_parameters() const { return !std::ranges::all_of(subjects, &Subject::laser) || subjects.empty(); }

  // What the requirement limits, of the subject that is worst; else the same as cost.
  double figure(const Knowledge& known) const {
    if (!requirement) return rms(known.parameters);
    double worst = 0.0;
    for (const Subject& subject : subjects) {
      const double value = figure(subject, known).value;
      if (std::isfinite(value)) worst = std::max(worst, value);
    }
    return worst;
  }

  // What views are chosen by: all places count, the worst ones most, so that views for different places add up.
  double cost(const Knowledge& known) const {
    if (!requirement) return rms(known.parameters);
    double squares = 0.0;
    for (const Subject& subject : subjects) {
      const double value = figure(subject, known).rms;
      if (std::isfinite(value)) squares += value * value;
    }
    return std::sqrt(squares);
  }

  Figure figure(const Subject& subject, const Knowledge& known) const {
    if (subject.laser) return figure_of_beams(beam_sigmas(calibration, known.beams, requirement->range_m));
    return figure_of(*requirement, subject, calibration, known.parameters, kPlacesAcross);
  }

  // Root mean square over all images.
  double rms(const Covariance& covariance) const {
    double sum = 0.0;
    int count = 0;
    for (const ImageSigmas& image : images) {
      for (const double variance : image.largest_variances(covariance.matrix)) {
        if (!std::isfinite(variance)) continue;
        sum += variance;
        ++count;
      }
    }
    return count > 0 ? std::sqrt(sum / count) : 0.0;
  }

  std::string words() const {
    return requirement ? "what '" + requirement->text + "' limits, at its worst, by the noise of the corners" +
                             (needs_beams() ? " and dots" : "")
                       : "the sigma of projections at infinity, root mean square over all images";
  }
};

// A candidate with what its views would add, and by how much it lowered the cost when it was last looked at.
struct Choice {
  BoardCandidate board;
  Information information;
  double gain = std::numeric_limits<double>::infinity();
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

// Gains hardly ever grow as views are added, so one that was too small in the round before need not be looked at again
// (lazy greedy selection, Minoux 1978).
const Choice& best_choice(const Objective& objective, const Start& start, const Information& added, int threads,
                          std::vector<Choice>& choices) {
  constexpr std::size_t kTogether = 32;  // are looked at, whatever the number of threads
  const double cost = objective.cost(start.with(added));
  std::ranges::stable_sort(choices, std::ranges::greater{}, &Choice::gain);
  std::size_t best = 0;
  double most = -std::numeric_limits<double>::infinity();
  for (std::size_t first = 0; first < choices.size() && choices[first].gain > most; first += kTogether) {
    const std::size_t end = std::min(first + kTogether, choices.size());
    for_each_index(end - first, threads, [&](std::size_t i) {
      Information with_this = added;
      with_this += choices[first + i].information;
      choices[first + i].gain = cost - objective.cost(start.with(with_this));
    });
    for (std::size_t i = first; i < end; ++i) {
      if (choices[i].gain > most) best = i, most = choices[i].gain;
    }
  }
  return choices[best];
}

}  // namespace

NextViews next_best_views(const CalibrationProblem& problem, const CalibrationResult& result,
                          const std::optional<Requirement>& requirement, int count, int threads) {
  const Calibration& calibration = result.calibration;
  const Objective objective(calibration, requirement);
  NextViews next;
  if (objective.requirement) next.quantity = objective.requirement->quantity;
  next.objective = objective.words();
  const std::optional<int> target = usual_target(problem);
  if (!target) return next;
  const std::vector<double> corner_px = corner_sigmas(problem, result);
  const double dot_px = dot_sigma(problem, result);
  const Start start(calibration);
  const ImaginedBoard imagined(calibration, *target);
  std::vector<Choice> choices;
  for (int c = 0; c < static_cast<int>(calibration.cameras.size()); ++c) {
    if (!calibration.cameras[c].evidence) continue;
    const CameraCoverage held = held_boards(problem, result, calibration.cameras[c]);
    for (BoardCandidate& board : board_candidates(calibration, c, *target, imagined, held)) {
      choices.push_back({std::move(board), {}});
    }
  }
  for_each_index(choices.size(), threads, [&](std::size_t i) {
    const Rigid3& pose = choices[i].board.rig_from_target;
    Information& information = choices[i].information;
    if (objective.needs_parameters()) {
      information.of_parameters = start.root.transpose() * (imagined.information(pose, corner_px) * start.root);
    }
    if (objective.needs_beams() && dot_px > 0.0) {
      information.of_beams = imagined_dots(calibration, *target, pose, dot_px);
      for (std::size_t b = 0; b < start.beam_roots.size(); ++b) {
        const Eigen::Matrix4d& root = start.beam_roots[b];
        information.of_beams[b] = root.transpose() * information.of_beams[b] * root;
      }
    }
  });
  Information added;
  double figure = objective.figure(start.known);
  for (int k = 0; k < count && !choices.empty(); ++k) {
    const Choice& best = best_choice(objective, start, added, threads, choices);
    if (!(best.gain > 0.0)) break;
    const Rigid3& pose = best.board.rig_from_target;
    added += best.information;
    const double before = std::exchange(figure, objective.figure(start.with(added)));
    NextView view{best.board.camera, *target, pose, best.board.text, before, figure, {}};
    for (const RigCamera& camera : calibration.cameras) {
      view.outlines.push_back(outline_in_image(camera, calibration.targets[*target].target, pose));
    }
    next.views.push_back(std::move(view));
  }
  return next;
}

}  // namespace raybundle
