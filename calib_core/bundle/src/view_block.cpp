// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/bundle/view_block.hpp"

#include <algorithm>
#include <cmath>

#include "raybundle/geometry/rotation.hpp"
#include "view_rows.hpp"

namespace raybundle {
namespace {

// Column of the view's [J r] for a column of ViewRows::u (axis 0) or v (axis 1).
int full_column(int column, int axis) { return column < 2 ? 2 * column + axis : column + 2; }

void resize(const ViewRows& rows, Eigen::Index count, ViewBlock& block) {
  block.residual.resize(count);
  block.wrt_intrinsics.resize(count, 4 + rows.model_shape_size);
  block.wrt_camera_from_rig.resize(count, 6);
  block.wrt_rig_from_target.resize(count, 6);
  block.wrt_shape.resize(count, rows.with_shape ? 3 : 0);
}

// Splits rows of the view's [J r] into the block's Jacobians. A motion (w, t) of rig_from_target turns the board by
// R w about its origin and shifts it by R t, R the rotation of camera_from_rig; one of camera_from_rig turns by w, but
// about the rig's origin, and shifts by t.
void split(const ViewBlock::Rows& full, const MotionMap& map, ViewBlock& block) {
  const Eigen::Index intrinsics = block.wrt_intrinsics.cols();
  const Eigen::Index count = full.rows();
  const Eigen::Matrix3d minus_arm = -skew(map.arm);
  block.wrt_intrinsics.topRows(count) = full.leftCols(intrinsics);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::RowVector3d turn = full.row(i).segment<3>(intrinsics);
    const Eigen::RowVector3d shift = full.row(i).segment<3>(intrinsics + 3);
    block.wrt_camera_from_rig.row(i) << turn + shift * minus_arm, shift;
    block.wrt_rig_from_target.row(i) << turn * map.camera_from_rig, shift * map.camera_from_rig;
  }
  if (block.wrt_shape.cols() > 0) block.wrt_shape.topRows(count) = full.middleCols<3>(intrinsics + 6);
  block.residual.head(count) = full.rightCols<1>();
}

// The row without a Jacobian; see ViewBlock.
void make_up_cost(double chi2, ViewBlock& block) {
  const Eigen::Index last = block.residual.size() - 1;
  block.residual[last] = std::sqrt(std::max(0.0, chi2));
  for (ViewBlock::Rows* rows :
       {&block.wrt_intrinsics, &block.wrt_camera_from_rig, &block.wrt_rig_from_target, &block.wrt_shape}) {
    rows->row(last).setZero();
  }
}

// Cholesky factor of the leading columns of [J r]ᵀ[J r] (upper triangle, row major), in place; the last column becomes
// R⁻ᵀ Jᵀr. The diagonal is raised by a relative 1e-13, a thousand roundings of a unit: a view of few corners does not
// determine all of its unknowns. That damps the step by as much and leaves the gradient Rᵀ(R⁻ᵀJᵀr) exact.
void factorize(ViewBlock::Rows& matrix) {
  const Eigen::Index n = matrix.cols() - 1;
  for (Eigen::Index j = 0; j < n; ++j) matrix(j, j) *= 1.0 + 1e-13;
  for (Eigen::Index j = 0; j < n; ++j) {
    double* pivot = &matrix(j, 0);
    const double root = pivot[j] > 0.0 ? std::sqrt(pivot[j]) : 0.0;
    const double inverse = root > 0.0 ? 1.0 / root : 0.0;
    for (Eigen::Index k = j; k <= n; ++k) pivot[k] *= inverse;
    for (Eigen::Index i = j + 1; i < n; ++i) {
      const double factor = pivot[i];
      double* row = &matrix(i, 0);
      for (Eigen::Index k = i; k <= n; ++k) row[k] -= factor * pivot[k];
    }
    for (Eigen::Index k = 0; k < j; ++k) pivot[k] = 0.0;
  }
}

void compress(const ViewRows& rows, const MotionMap& map, ViewBlock& block) {
  thread_local Eigen::MatrixXd product;
  thread_local ViewBlock::Rows full;
  const int unknowns = rows.unknowns();
  full.setZero(unknowns, unknowns + 1);
  for (int axis = 0; axis < 2; ++axis) {
    gram(axis == 0 ? rows.u : rows.v, product);
    for (int a = 0; a < rows.columns() - 1; ++a) {
      for (int b = a; b < rows.columns(); ++b) full(full_column(a, axis), full_column(b, axis)) += product(a, b);
    }
  }
  factorize(full);
  resize(rows, unknowns + 1, block);
  split(full, map, block);
  make_up_cost(rows.robust_chi2 - block.residual.head(unknowns).squaredNorm(), block);
}

void keep_whole(const ViewRows& rows, const MotionMap& map, ViewBlock& block) {
  ViewBlock::Rows full = ViewBlock::Rows::Zero(2 * rows.corners, rows.unknowns() + 1);
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::MatrixXd& side = axis == 0 ? rows.u : rows.v;
    for (int column = 0; column < rows.columns(); ++column) {
      for (int i = 0; i < rows.corners; ++i) full(2 * i + axis, full_column(column, axis)) = side(i, column);
    }
  }
  resize(rows, full.rows() + 1, block);
  split(full, map, block);
  make_up_cost(rows.robust_chi2 - rows.weighted_chi2, block);
}

}  // namespace

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
                  .x_in_target = Eigen::Matrix3Xd(3, used),
                  .shape_basis = Eigen::Matrix3Xd(3, used),
                  .pixel = Eigen::Matrix2Xd(2, used),
                  .inverse_sigma = Eigen::ArrayXd(used)};
    Eigen::Index i = 0;
    for (std::size_t k = 0; k < view.observations.size(); ++k) {
      if (state.fates[v][k] != ObservationFate::kUsed) continue;
      const Observation& observation = view.observations[k];
      const TargetPoint* point = target.find(observation.point_id);
      data.x_in_target.col(i) = point->x_in_target;
      data.shape_basis.col(i) = bases[view.target][point - target.points.data()];
      data.pixel.col(i) = observation.pixel;
      data.inverse_sigma[i++] = 1.0 / observation.sigma_px;
    }
    views.push_back(std::move(data));
  }
  return views;
}

int view_block_rows(const ViewData& view, const ViewBlockOptions& options) {
  if (!options.compressed) return 2 * static_cast<int>(view.pixel.cols()) + 1;
  const int intrinsics = with_model(view.model, []<CameraModel M>() { return kParameterCount<M>; });
  return intrinsics + 6 + (options.with_shape ? 3 : 0) + 1;
}

bool linearize_view(const ViewData& view, const ViewPoint& point, const ViewBlockOptions& options, ViewBlock& block) {
  thread_local ViewRows rows;
  const MotionMap map(point);
  if (!fill_rows(view, point, map, options, rows)) return false;
  if (options.compressed) {
    compress(rows, map, block);
  } else {
    keep_whole(rows, map, block);
  }
  return true;
}

}  // namespace raybundle
