// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "view_rows.hpp"

#include <cmath>

#include "raybundle/camera/lanes.hpp"
#include "raybundle/geometry/gram.hpp"
#include "raybundle/geometry/rotation.hpp"
#include "raybundle/geometry/target_clones.hpp"

namespace raybundle {
namespace {

// The corners' offsets from the board's origin, in camera axes, and their weights; one entry for each row of ViewRows.
struct Corners {
  Eigen::Matrix<double, Eigen::Dynamic, 3> offset;
  Eigen::VectorXd weight;    // 1/sigma, later with the root of ρ'
  Eigen::VectorXd nearness;  // as BoardPoints
};

// What the model says of corner i, or of the Lanes::kCount from there on, into the columns where it stays: plane point,
// its derivatives by the model's shape and, in the columns of the translation, by the ray.
template <CameraModel M, typename Number>
[[gnu::always_inline]] inline bool project_at(Eigen::Index i, const ViewData& view, const ViewPoint& point,
                                              const MotionMap& map, Corners& corners, ViewRows& rows) {
  constexpr int n = kShapeSize<M>;
  Number x[3];
  for (int k = 0; k < 3; ++k) load(&view.points->x_in_target(i, k), x[k]);
  for (int k = 0; k < 3; ++k) {
    Number basis;
    load(&view.points->shape_basis(i, k), basis);
    x[2] += basis * Number(point.shape[k]);
  }
  Number nearness;
  load(&corners.nearness[i], nearness);
  Number ray[3];
  for (int r = 0; r < 3; ++r) {
    const auto to = [&](int k) { return Number(map.camera_from_target(r, k)); };
    const Number offset = to(0) * x[0] + to(1) * x[1] + to(2) * x[2];
    store(offset, &corners.offset(i, r));
    ray[r] = offset + nearness * Number(map.translation[r]);
  }
  Number model_shape[n > 0 ? n : 1];
  for (int k = 0; k < n; ++k) model_shape[k] = Number(point.intrinsics[4 + k]);
  Number plane[2];
  Number wrt_ray[6];
  Number wrt_model_shape[n > 0 ? 2 * n : 1];
  if (!M::plane_from_ray(model_shape, ray, plane, wrt_ray, wrt_model_shape)) return false;
  for (int axis = 0; axis < 2; ++axis) {
    Eigen::MatrixXd& side = axis == 0 ? rows.u : rows.v;
    store(plane[axis], &side(i, 0));
    for (int k = 0; k < n; ++k) store(wrt_model_shape[axis * n + k], &side(i, 2 + k));
    for (int k = 0; k < 3; ++k) store(wrt_ray[3 * axis + k], &side(i, rows.motion() + 3 + k));
  }
  return true;
}

template <CameraModel M>
RAYBUNDLE_TARGET_CLONES [[gnu::flatten]] bool project(const ViewData& view, const ViewPoint& point,
                                                      const MotionMap& map, Corners& corners, ViewRows& rows) {
  bool all = true;
  for_each_in_lanes(
      static_cast<Eigen::Index>(rows.corners),
      [&]<typename Number>(Eigen::Index i)
          __attribute__((always_inline)) { return project_at<M, Number>(i, view, point, map, corners, rows); },
      [&](Eigen::Index) { all = false; });
  return all;
}

// Cauchy: ρ(s) = c² log(1 + s / c²), ρ'(s) = 1 / (1 + s / c²); plain least squares for c = 0.
void weigh(double scale, Corners& corners, ViewRows& rows) {
  auto residual_u = rows.u.rightCols<1>().array();
  auto residual_v = rows.v.rightCols<1>().array();
  if (scale <= 0.0) {
    rows.robust_chi2 = rows.weighted_chi2 = residual_u.square().sum() + residual_v.square().sum();
    return;
  }
  const double c2 = scale * scale;
  rows.robust_chi2 = rows.weighted_chi2 = 0.0;
  for (int i = 0; i < rows.corners; ++i) {
    const double s = residual_u[i] * residual_u[i] + residual_v[i] * residual_v[i];
    const double weight = 1.0 / (1.0 + s / c2);
    const double root = std::sqrt(weight);
    rows.robust_chi2 += c2 * std::log1p(s / c2);
    rows.weighted_chi2 += weight * s;
    residual_u[i] *= root;
    residual_v[i] *= root;
    corners.weight[i] *= root;
  }
}

// Residual column of one axis, whitened: projected minus measured.
RAYBUNDLE_TARGET_CLONES
void subtract(const ViewData& view, const ViewPoint& point, int axis, const Corners& corners, Eigen::MatrixXd& side) {
  const Eigen::Index count = view.pixel.rows();
  const double focal = point.intrinsics[axis];
  const double principal = point.intrinsics[2 + axis];
  const double* plane = side.data();
  const double* pixel = view.pixel.col(axis).data();
  const double* weight = corners.weight.data();
  double* residual = side.rightCols<1>().data();
  for (Eigen::Index i = 0; i < count; ++i) {
    residual[i] = (focal * plane[i] + principal - pixel[i]) * weight[i];
  }
}

// Turns what project() left in one axis' columns into derivatives of the weighted pixel coordinate.
RAYBUNDLE_TARGET_CLONES
void differentiate(double focal, const Corners& corners, int model_shape_size, Eigen::MatrixXd& side) {
  const Eigen::Index stride = side.rows();
  const double* __restrict weight = corners.weight.data();
  double* __restrict plane = side.data();
  double* __restrict principal = plane + stride;
  for (Eigen::Index i = 0; i < stride; ++i) {
    plane[i] *= weight[i];
    principal[i] = weight[i];
  }
  double* __restrict model_shape = principal + stride;
  for (int k = 0; k < model_shape_size; ++k, model_shape += stride) {
    for (Eigen::Index i = 0; i < stride; ++i) model_shape[i] *= focal * weight[i];
  }
  double* __restrict turn = model_shape;
  double* __restrict slope = turn + 3 * stride;
  const double* __restrict offset = corners.offset.data();
  const double* __restrict nearness = corners.nearness.data();
  for (Eigen::Index i = 0; i < stride; ++i) {
    const double scale = focal * weight[i];
    const double sx = slope[i] * scale, sy = slope[i + stride] * scale, sz = slope[i + 2 * stride] * scale;
    const double ox = offset[i], oy = offset[i + stride], oz = offset[i + 2 * stride];
    const double near = nearness[i];
    slope[i] = near * sx;
    slope[i + stride] = near * sy;
    slope[i + 2 * stride] = near * sz;
    turn[i] = oy * sz - oz * sy;  // slopeᵀ (w × offset) = (offset × slope)ᵀ w
    turn[i + stride] = oz * sx - ox * sz;
    turn[i + 2 * stride] = ox * sy - oy * sx;
  }
}

// Columns of the board's shape, which moves points along the board's normal.
void differentiate_shape(const ViewData& view, const Eigen::Vector3d& normal, int motion, Eigen::MatrixXd& side) {
  const Eigen::Index count = view.pixel.rows();
  const Eigen::VectorXd along_normal = side.middleCols<3>(motion + 3).topRows(count) * normal;
  for (int k = 0; k < 3; ++k) {
    side.col(motion + 6 + k).head(count) = along_normal.cwiseProduct(view.points->shape_basis.col(k));
  }
}

void resize(const ViewData& view, const ViewBlockOptions& options, int model_shape_size, Corners& corners,
            ViewRows& rows) {
  rows.corners = static_cast<int>(view.pixel.rows());
  rows.model_shape_size = model_shape_size;
  rows.with_shape = options.with_shape;
  const Eigen::Index padded = padded_for_gram(rows.corners);
  for (Eigen::MatrixXd* side : {&rows.u, &rows.v}) {
    side->resize(padded, rows.columns());
    side->bottomRows(padded - rows.corners).setZero();
  }
  corners.offset.resize(padded, 3);
  corners.offset.bottomRows(padded - rows.corners).setZero();
  corners.weight.resize(padded);
  corners.weight.head(rows.corners) = view.inverse_sigma;
  corners.weight.tail(padded - rows.corners).setZero();
  corners.nearness.resize(padded);
  corners.nearness.head(rows.corners) = view.points->nearness;
  corners.nearness.tail(padded - rows.corners).setZero();
}

}  // namespace

MotionMap::MotionMap(const ViewPoint& point)
    : camera_from_rig(point.camera_from_rig.rotation.toRotationMatrix()),
      camera_from_target(camera_from_rig * point.rig_from_target.rotation.toRotationMatrix()),
      arm(camera_from_rig * point.rig_from_target.translation),
      translation(arm + point.camera_from_rig.translation) {}

Eigen::Matrix<double, 6, 6> MotionMap::wrt_rig_from_target() const {
  Eigen::Matrix<double, 6, 6> map = Eigen::Matrix<double, 6, 6>::Zero();
  map.topLeftCorner<3, 3>() = map.bottomRightCorner<3, 3>() = camera_from_rig;
  return map;
}

Eigen::Matrix<double, 6, 6> MotionMap::wrt_camera_from_rig() const {
  Eigen::Matrix<double, 6, 6> map = Eigen::Matrix<double, 6, 6>::Identity();
  map.bottomLeftCorner<3, 3>() = -skew(arm);
  return map;
}

namespace {

// Leaves residuals and their sums in the rows, and in their other columns what project() does.
bool fill_residuals(const ViewData& view, const ViewPoint& point, const MotionMap& map, const ViewBlockOptions& options,
                    Corners& corners, ViewRows& rows) {
  if (!(point.intrinsics[0] > 0.0) || !(point.intrinsics[1] > 0.0)) return false;
  const bool projectable = with_model(view.model, [&]<CameraModel M>() {
    resize(view, options, kShapeSize<M>, corners, rows);
    return project<M>(view, point, map, corners, rows);
  });
  if (!projectable) return false;
  subtract(view, point, 0, corners, rows.u);
  subtract(view, point, 1, corners, rows.v);
  weigh(options.robust_scale_sigma, corners, rows);
  return true;
}

}  // namespace

std::optional<double> view_chi2(const ViewData& view, const ViewPoint& point, const ViewBlockOptions& options) {
  thread_local Corners corners;
  thread_local ViewRows rows;
  if (!fill_residuals(view, point, MotionMap(point), options, corners, rows)) return std::nullopt;
  return rows.robust_chi2;
}

bool fill_rows(const ViewData& view, const ViewPoint& point, const MotionMap& map, const ViewBlockOptions& options,
               ViewRows& rows) {
  thread_local Corners corners;
  if (!fill_residuals(view, point, map, options, corners, rows)) return false;
  differentiate(point.intrinsics[0], corners, rows.model_shape_size, rows.u);
  differentiate(point.intrinsics[1], corners, rows.model_shape_size, rows.v);
  if (rows.with_shape) {
    differentiate_shape(view, map.camera_from_target.col(2), rows.motion(), rows.u);
    differentiate_shape(view, map.camera_from_target.col(2), rows.motion(), rows.v);
  }
  return true;
}

}  // namespace raybundle
