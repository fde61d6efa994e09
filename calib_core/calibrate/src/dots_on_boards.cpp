// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "dots_on_boards.hpp"

#include <algorithm>
#include <limits>

#include "raybundle/geometry/quantile.hpp"
#include "raybundle/scene/board_surface.hpp"

namespace raybundle {
namespace {

constexpr double kMargin = 1.5;  // spacings: a chessboard's outermost squares and the white around them

/// Typical distance of a point to the nearest other one [m].
double spacing_m(const Target& target) {
  std::vector<double> distances;
  for (const TargetPoint& point : target.points) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const TargetPoint& other : target.points) {
      if (other.id == point.id) continue;
      nearest = std::min(nearest, (other.x_in_target - point.x_in_target).norm());
    }
    distances.push_back(nearest);
  }
  return median(distances);
}

}  // namespace

std::vector<std::vector<bool>> dots_on_boards(const CalibrationProblem& problem, const BundleState& state) {
  std::vector<double> margins_m;
  for (const Target& target : problem.targets) margins_m.push_back(kMargin * spacing_m(target));
  std::vector<std::vector<bool>> on;
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    const TargetView& view = problem.views[v];
    std::vector<bool>& of_view = on.emplace_back(view.dots.size(), false);
    if (state.pose_of_view[v] < 0 || view.dots.empty()) continue;
    const BoardSurface surface(problem.targets[view.target]);
    const Rigid3 target_from_camera =
        (state.camera_from_rig[view.camera] * state.poses[state.pose_of_view[v]].rig_from_target).inverse();
    for (std::size_t i = 0; i < view.dots.size(); ++i) {
      const auto ray = ray_from_pixel(state.cameras[view.camera], view.dots[i].pixel);
      if (!ray) continue;
      const auto place = surface.crossing({target_from_camera.translation, target_from_camera.rotation * *ray},
                                          state.shapes[view.target]);
      of_view[i] = place && surface.covers(*place, margins_m[view.target]);
    }
  }
  return on;
}

CalibrationProblem with_dots(const CalibrationProblem& problem, const std::vector<std::vector<bool>>& kept) {
  CalibrationProblem result = problem;
  for (std::size_t v = 0; v < result.views.size(); ++v) {
    std::vector<Dot>& dots = result.views[v].dots;
    dots.clear();
    for (std::size_t i = 0; i < kept[v].size(); ++i) {
      if (kept[v][i]) dots.push_back(problem.views[v].dots[i]);
    }
  }
  return result;
}

std::vector<std::vector<int>> for_all_dots(const std::vector<std::vector<int>>& of_kept,
                                           const std::vector<std::vector<bool>>& kept, int other) {
  std::vector<std::vector<int>> all;
  for (std::size_t v = 0; v < kept.size(); ++v) {
    std::vector<int>& of_view = all.emplace_back();
    std::size_t next = 0;
    for (const bool is_kept : kept[v]) of_view.push_back(is_kept ? of_kept[v][next++] : other);
  }
  return all;
}

}  // namespace raybundle
