// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/second_opinion.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "mrcal_solve.hpp"
#include "raybundle/bundle/bundle.hpp"

namespace raybundle {
namespace {

std::optional<std::string> mrcal_name(ModelId model) {
  for (const ForeignName& foreign : foreign_names(model)) {
    if (foreign.format == "mrcal") return std::string(foreign.name);
  }
  return std::nullopt;
}

// The lattice that all points of a board lie on, when it is not much larger than the board.
std::optional<GridOfPoints> grid_of(const Target& target) {
  constexpr int kMostNodesPerPoint = 4;
  if (target.points.empty() || !target.flat()) return std::nullopt;
  Eigen::Vector2d least = target.points[0].x_in_target.head<2>(), most = least;
  for (const TargetPoint& point : target.points) {
    least = least.cwiseMin(point.x_in_target.head<2>());
    most = most.cwiseMax(point.x_in_target.head<2>());
  }
  const double tolerance_m = 1e-6 * (most - least).norm();
  double spacing_m = (most - least).norm();
  for (const TargetPoint& point : target.points) {
    for (int axis = 0; axis < 2; ++axis) {
      const double offset = point.x_in_target[axis] - least[axis];
      if (offset > tolerance_m) spacing_m = std::min(spacing_m, offset);
    }
  }
  GridOfPoints grid{.spacing_m = spacing_m, .origin_m = least};
  grid.columns = static_cast<int>(std::lround((most.x() - least.x()) / spacing_m)) + 1;
  grid.rows = static_cast<int>(std::lround((most.y() - least.y()) / spacing_m)) + 1;
  if (static_cast<double>(grid.columns) * grid.rows > kMostNodesPerPoint * static_cast<double>(target.points.size())) {
    return std::nullopt;
  }
  for (const TargetPoint& point : target.points) {
    const Eigen::Vector2d at = (point.x_in_target.head<2>() - least) / spacing_m;
    const Eigen::Vector2d node = at.array().round();
    if ((at - node).norm() * spacing_m > 10.0 * tolerance_m) return std::nullopt;
    grid.node_of_point.push_back(static_cast<int>(node.y()) * grid.columns + static_cast<int>(node.x()));
  }
  return grid;
}

bool bent(const BoardShape& shape) { return shape.bend_x_m != 0.0 || shape.bend_y_m != 0.0 || shape.twist_m != 0.0; }

// A view with the point ids that the solve gave it.
TargetView relabelled_view(const CalibrationProblem& problem, TargetView view, int symmetry) {
  if (symmetry < 0) return view;
  const Target& board = problem.targets[view.target];
  for (Observation& observation : view.observations) {
    observation.point_id = board.symmetries[symmetry].ids[board.find(observation.point_id) - board.points.data()];
  }
  return view;
}

// The first opinion's solve once more, of the corners alone and with boards that bend but do not twist.
Calibration as_mrcal_solves(const CalibrationProblem& problem, const CalibrationResult& first) {
  CalibrationProblem held = problem;
  held.laser.reset();
  held.rules.clear();
  for (const Target& target : problem.targets) {
    held.rules.push_back({target.name + ".twist", ParameterRule::Kind::kFixed, 0.0});
  }
  BundleState state;
  for (const RigCamera& camera : first.calibration.cameras) {
    state.cameras.push_back(camera.camera);
    state.camera_from_rig.push_back(camera.camera_from_rig);
  }
  for (const CalibratedTarget& target : first.calibration.targets) state.shapes.push_back(target.shape);
  state.poses = first.poses;
  for (std::size_t v = 0; v < held.views.size(); ++v) {
    state.pose_of_view.push_back(first.views[v].pose);
    state.fates.push_back(first.views[v].fates);
    held.views[v] = relabelled_view(held, held.views[v], first.views[v].symmetry);
  }
  solve_bundle(held, state, {.estimate_shape = bent(first.calibration.targets[first.poses[0].target].shape)});
  Calibration calibration = first.calibration;
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    calibration.cameras[c].camera = state.cameras[c];
    calibration.cameras[c].camera_from_rig = state.camera_from_rig[c];
  }
  return calibration;
}

// Some percent away: mrcal has to find the optimum itself, and nothing is degenerate as without distortion.
std::vector<RigCamera> disturbed(std::vector<RigCamera> cameras) {
  for (RigCamera& camera : cameras) {
    Eigen::VectorXd& parameters = camera.camera.parameters;
    parameters.head<2>() *= 1.02;
    parameters.tail(parameters.size() - 4) *= 0.9;
  }
  return cameras;
}

// Why there cannot be a second opinion; empty when there can.
std::string objection(const CalibrationProblem& problem, const CalibrationResult& first) {
  if (!mrcal_available()) return "this build has no mrcal; install libmrcal-dev and build again";
  const std::vector<RigCamera>& cameras = first.calibration.cameras;
  for (const RigCamera& camera : cameras) {
    const std::string model(model_name(camera.camera.model));
    if (!mrcal_name(camera.camera.model)) return "mrcal has no model like " + model;
    if (camera.camera.model != cameras[0].camera.model) return "mrcal gives all cameras of a rig the same model";
  }
  if (cameras.size() != problem.cameras.size()) return "not all cameras could be calibrated";
  const bool ruled = std::ranges::any_of(
      problem.rules, [](const ParameterRule& rule) { return rule.kind != ParameterRule::Kind::kFree; });
  if (ruled) return "parameters are fixed or have priors, which mrcal's optimiser does not know";
  std::set<int> targets;
  for (const BoardPose& pose : first.poses) targets.insert(pose.target);
  if (targets.size() != 1) return "mrcal knows one board only";
  if (!grid_of(problem.targets[*targets.begin()])) return "mrcal knows boards that are regular grids only";
  return {};
}

// The corners that the first opinion used, and a start.
MrcalProblem request_of(const CalibrationProblem& problem, const CalibrationResult& first) {
  const int target = first.poses[0].target;
  const Target& board = problem.targets[target];
  MrcalProblem request{.lens_model = *mrcal_name(first.calibration.cameras[0].camera.model), .grid = *grid_of(board)};
  request.with_shape = bent(first.calibration.targets[target].shape);
  request.cameras = disturbed(first.calibration.cameras);
  for (const BoardPose& pose : first.poses) request.rig_from_target.push_back(pose.rig_from_target);
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    const ViewResult& view = first.views[v];
    if (view.pose < 0) continue;
    MrcalView seen{.camera = problem.views[v].camera, .pose = view.pose, .corners = {}};
    const TargetView labelled = relabelled_view(problem, problem.views[v], view.symmetry);
    for (std::size_t i = 0; i < view.fates.size(); ++i) {
      if (view.fates[i] != ObservationFate::kUsed) continue;
      const Observation& observation = labelled.observations[i];
      const auto place = static_cast<std::size_t>(board.find(observation.point_id) - board.points.data());
      seen.corners.push_back({request.grid.node_of_point[place], observation.pixel, 1.0 / observation.sigma_px});
    }
    request.views.push_back(std::move(seen));
  }
  return request;
}

}  // namespace

SecondOpinion second_opinion(const CalibrationProblem& problem, const CalibrationResult& first) {
  SecondOpinion opinion;
  opinion.why_not = objection(problem, first);
  if (!opinion.why_not.empty()) return opinion;
  MrcalProblem request = request_of(problem, first);
  opinion.source = "mrcal, " + request.lens_model;
  std::optional<MrcalAnswer> answer = solve_with_mrcal(request);
  request.cameras = first.calibration.cameras;
  const std::optional<MrcalAnswer> from_first = solve_with_mrcal(request);
  if (!answer || (from_first && from_first->rms_px < 0.999 * answer->rms_px)) {
    answer = from_first;
    opinion.source += " (from the first opinion's lenses)";
  }
  if (!answer) {
    opinion.why_not = "mrcal's optimiser did not find a solution";
    return opinion;
  }
  opinion.rms_px = answer->rms_px;
  opinion.counterpart = first.calibration;
  const bool twisted = first.calibration.targets[first.poses[0].target].shape.twist_m != 0.0;
  if (twisted || first.laser) {
    opinion.counterpart = as_mrcal_solves(problem, first);
    opinion.remark = "held against our solve of the corners without the board's twist, which mrcal does not know";
  }
  opinion.calibration = first.calibration;
  opinion.calibration->laser.reset();
  for (std::size_t c = 0; c < answer->cameras.size(); ++c) {
    opinion.calibration->cameras[c].camera.parameters = answer->cameras[c].camera.parameters;
    opinion.calibration->cameras[c].camera_from_rig = answer->cameras[c].camera_from_rig;
  }
  return opinion;
}

}  // namespace raybundle
