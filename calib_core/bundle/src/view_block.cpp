// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/bundle/view_block.hpp"

#include <algorithm>
#include <cmath>

#include "view_rows.hpp"

namespace raybundle {

std::vector<ViewData> used_views(const CalibrationProblem& problem, const BundleState& state) {
  std::vector<std::vector<Eigen::Vector3d>> bases;
  for (const Target& target : problem.targets) bases.push_back(shape_basis(target));
  std::vector<ViewData> views;
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    const TargetView& view = problem.views[v];
    const auto used = std::ranges::count(state.fates[v], ObservationFate::kUsed);
    if (state.pose_of_view[v] < 0 || used == 0) continue;
    const Target& target = problem.targets[view.target];
    ViewData data{.view = v,
                  .camera = view.camera,
                  .target = view.target,
                  .pose = state.pose_of_view[v],
                  .model = state.cameras[view.camera].model,
                  .x_in_target = Eigen::MatrixX3d(used, 3),
                  .nearness = Eigen::ArrayXd(used),
                  .shape_basis = Eigen::MatrixX3d(used, 3),
                  .pixel = Eigen::MatrixX2d(used, 2),
                  .inverse_sigma = Eigen::ArrayXd(used)};
    Eigen::Index i = 0;
    for (std::size_t k = 0; k < view.observations.size(); ++k) {
      if (state.fates[v][k] != ObservationFate::kUsed) continue;
      const Observation& observation = view.observations[k];
      const TargetPoint* point = target.find(observation.point_id);
      data.x_in_target.row(i) = point->x_in_target.transpose();
      data.nearness[i] = point->infinitely_far ? 0.0 : 1.0;
      data.shape_basis.row(i) = bases[view.target][point - target.points.data()].transpose();
      data.pixel.row(i) = observation.pixel.transpose();
      data.inverse_sigma[i++] = 1.0 / observation.sigma_px;
    }
    views.push_back(std::move(data));
  }
  return views;
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
