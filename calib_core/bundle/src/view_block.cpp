// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/bundle/view_block.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "view_data.hpp"
#include "view_rows.hpp"

namespace raybundle {

namespace {

// Boards that are seen whole show the same points in every view.
class PointsInUse {
 public:
  explicit PointsInUse(const CalibrationProblem& problem) : problem_(problem), last_(problem.targets.size()) {
    for (const Target& target : problem.targets) bases_.push_back(shape_basis(target));
  }

  // @param used  which of the target's points
  std::shared_ptr<const BoardPoints> of(int target, std::vector<int>&& used) {
    Last& last = last_[target];
    if (!last.points || used != last.used) {
      last.points = std::make_shared<BoardPoints>(problem_.targets[target], bases_[target], used);
      last.used = std::move(used);
    }
    return last.points;
  }

 private:
  struct Last {
    std::vector<int> used;
    std::shared_ptr<const BoardPoints> points;
  };
  const CalibrationProblem& problem_;
  std::vector<std::vector<Eigen::Vector3d>> bases_;  // of the targets
  std::vector<Last> last_;                           // of the targets
};

// Fills in what was measured.
//
// @return  which of the target's points the view uses, in the order of its observations
std::vector<int> gather(const Target& target, const TargetView& view, const std::vector<ObservationFate>& fates,
                        ViewData& data) {
  const auto count = std::ranges::count(fates, ObservationFate::kUsed);
  data.pixel.resize(count, 2);
  data.inverse_sigma.resize(count);
  std::vector<int> used;
  used.reserve(static_cast<std::size_t>(count));
  for (std::size_t k = 0; k < fates.size(); ++k) {
    if (fates[k] != ObservationFate::kUsed) continue;
    const Observation& observation = view.observations[k];
    const auto i = static_cast<Eigen::Index>(used.size());
    data.pixel.row(i) = observation.pixel.transpose();
    data.inverse_sigma[i] = 1.0 / observation.sigma_px;
    used.push_back(static_cast<int>(target.find(observation.point_id) - target.points.data()));
  }
  return used;
}

}  // namespace

BoardPoints::BoardPoints(const Target& target, const std::vector<Eigen::Vector3d>& basis, const std::vector<int>& used)
    : x_in_target(used.size(), 3), nearness(used.size()), shape_basis(used.size(), 3) {
  for (Eigen::Index i = 0; i < nearness.size(); ++i) {
    const TargetPoint& point = target.points[used[i]];
    x_in_target.row(i) = point.x_in_target.transpose();
    nearness[i] = point.infinitely_far ? 0.0 : 1.0;
    shape_basis.row(i) = basis[used[i]].transpose();
  }
}

std::vector<ViewData> used_views(const CalibrationProblem& problem, const BundleState& state, Workers& workers) {
  std::vector<ViewData> views;
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    const bool any = std::ranges::find(state.fates[v], ObservationFate::kUsed) != state.fates[v].end();
    if (state.pose_of_view[v] < 0 || !any) continue;
    const TargetView& view = problem.views[v];
    views.push_back({.view = v,
                     .camera = view.camera,
                     .target = view.target,
                     .pose = state.pose_of_view[v],
                     .model = state.cameras[view.camera].model,
                     .points = {},
                     .pixel = {},
                     .inverse_sigma = {}});
  }
  std::vector<std::vector<int>> used(views.size());
  workers.for_each(static_cast<int>(views.size()), [&](int i) {
    const TargetView& view = problem.views[views[i].view];
    used[i] = gather(problem.targets[view.target], view, state.fates[views[i].view], views[i]);
  });
  PointsInUse points(problem);
  for (std::size_t i = 0; i < views.size(); ++i) views[i].points = points.of(views[i].target, std::move(used[i]));
  return views;
}

ViewData view_data(const Target& target, const TargetView& view, const std::vector<ObservationFate>& fates) {
  ViewData data;
  const std::vector<int> used = gather(target, view, fates, data);
  data.points = std::make_shared<BoardPoints>(target, shape_basis(target), used);
  return data;
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
