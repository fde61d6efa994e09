// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "mrcal_request.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace raybundle {
namespace {

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

}  // namespace

bool is_bent(const BoardShape& shape) { return shape.sags() != Eigen::Vector3d::Zero(); }

std::string mrcal_objection(const CalibrationProblem& problem, const CalibrationResult& first) {
  if (!mrcal_available()) return "this build has no mrcal; install libmrcal-dev and build again";
  if (first.calibration.cameras.size() != problem.cameras.size()) return "not all cameras could be calibrated";
  const bool ruled = std::ranges::any_of(
      problem.rules, [](const ParameterRule& rule) { return rule.kind != ParameterRule::Kind::kFree; });
  if (ruled) return "parameters are fixed or have priors, which mrcal's optimiser does not know";
  std::set<int> targets;
  for (const BoardPose& pose : first.poses) targets.insert(pose.target);
  if (targets.size() != 1) return "mrcal knows one board only";
  if (!grid_of(problem.targets[*targets.begin()])) return "mrcal knows boards that are regular grids only";
  return {};
}

MrcalProblem mrcal_request(const CalibrationProblem& problem, const CalibrationResult& first) {
  const int target = first.poses[0].target;
  const Target& board = problem.targets[target];
  MrcalProblem request{.lens_model = {}, .grid = *grid_of(board)};
  request.with_shape = is_bent(first.calibration.targets[target].shape);
  for (const RigCamera& camera : first.calibration.cameras) {
    request.cameras.push_back({camera.camera.size, {}, camera.camera_from_rig});
  }
  for (const BoardPose& pose : first.poses) request.rig_from_target.push_back(pose.rig_from_target);
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    const ViewResult& view = first.views[v];
    if (view.pose < 0) continue;
    MrcalView seen{.camera = problem.views[v].camera, .pose = view.pose, .corners = {}};
    std::vector<Observation> observations = problem.views[v].observations;
    relabel(board, view.symmetry, observations);
    for (std::size_t i = 0; i < view.fates.size(); ++i) {
      if (view.fates[i] != ObservationFate::kUsed) continue;
      const Observation& observation = observations[i];
      const auto place = static_cast<std::size_t>(board.find(observation.point_id) - board.points.data());
      seen.corners.push_back({request.grid.node_of_point[place], observation.pixel, 1.0 / observation.sigma_px,
                              observation.pixel - view.residuals_px[i]});
    }
    request.views.push_back(std::move(seen));
  }
  return request;
}

}  // namespace raybundle
