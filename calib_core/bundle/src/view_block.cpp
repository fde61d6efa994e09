// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/bundle/view_block.hpp"

#include <algorithm>
#include <cmath>

#include "view_data.hpp"
#include "view_rows.hpp"

namespace raybundle {

namespace {

// @param basis  of the view's target, as shape_basis()
void gather(const CalibrationProblem& problem, const BundleState& state, const std::vector<Eigen::Vector3d>& basis,
            ViewData& data) {
  const TargetView& view = problem.views[data.view];
  const std::vector<ObservationFate>& fates = state.fates[data.view];
  const Target& target = problem.targets[view.target];
  const auto used = std::ranges::count(fates, ObservationFate::kUsed);
  data.camera = view.camera;
  data.target = view.target;
  data.pose = state.pose_of_view[data.view];
  data.model = state.cameras[view.camera].model;
  data.x_in_target.resize(used, 3);
  data.nearness.resize(used);
  data.shape_basis.resize(used, 3);
  data.pixel.resize(used, 2);
  data.inverse_sigma.resize(used);
  Eigen::Index i = 0;
  for (std::size_t k = 0; k < view.observations.size(); ++k) {
    if (fates[k] != ObservationFate::kUsed) continue;
    const Observation& observation = view.observations[k];
    const TargetPoint* point = target.find(observation.point_id);
    data.x_in_target.row(i) = point->x_in_target.transpose();
    data.nearness[i] = point->infinitely_far ? 0.0 : 1.0;
    data.shape_basis.row(i) = basis[point - target.points.data()].transpose();
    data.pixel.row(i) = observation.pixel.transpose();
    data.inverse_sigma[i++] = 1.0 / observation.sigma_px;
  }
}

}  // namespace

std::vector<ViewData> used_views(const CalibrationProblem& problem, const BundleState& state, Workers& workers) {
  std::vector<std::vector<Eigen::Vector3d>> bases;
  for (const Target& target : problem.targets) bases.push_back(shape_basis(target));
  std::vector<ViewData> views;
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    const bool any = std::ranges::find(state.fates[v], ObservationFate::kUsed) != state.fates[v].end();
    if (state.pose_of_view[v] >= 0 && any) views.emplace_back().view = v;
  }
  workers.for_each(static_cast<int>(views.size()),
                   [&](int i) { gather(problem, state, bases[problem.views[views[i].view].target], views[i]); });
  return views;
}

std::vector<ViewData> used_views(const CalibrationProblem& problem, const BundleState& state) {
  Workers alone(1);
  return used_views(problem, state, alone);
}

bool linearize_view(const ViewData& view, const ViewPoint& point, const ViewBlockOptions& options, ViewBlock& block) {
  thread_local ViewRows rows;
  const MotionMap map(point);
  if (!fill_rows(view, point, map, options, rows)) return false;
  ViewBlock::Rows full = ViewBlock::Rows::Zero(2 * rows.corners + 1, rows.unknowns() + 1);
  for (int i = 0; i < rows.corners; ++i) {
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::MatrixXd& side = axis == 0 ? rows.u : rows.v;
      double* row = &full(2 * i + axis, 0);
      for (int column = 0; column < rows.columns(); ++column) {
        row[ViewRows::full_column(column, axis)] = side(i, column);
      }
    }
  }
  const int intrinsics = 4 + rows.model_shape_size;
  const auto motion = full.middleCols<6>(intrinsics);
  block.wrt_intrinsics = full.leftCols(intrinsics);
  block.wrt_camera_from_rig = motion * map.wrt_camera_from_rig();
  block.wrt_rig_from_target = motion * map.wrt_rig_from_target();
  block.wrt_shape = full.middleCols(intrinsics + 6, rows.with_shape ? 3 : 0);
  block.residual = full.rightCols<1>();
  block.residual.tail<1>()[0] = std::sqrt(std::max(0.0, rows.robust_chi2 - rows.weighted_chi2));
  return true;
}

}  // namespace raybundle
