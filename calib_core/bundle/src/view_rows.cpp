// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "view_rows.hpp"

#include <cmath>

namespace raybundle {
namespace {

struct CornerLoss {
  double value = 0.0;   ///< ρ(s)
  double weight = 1.0;  ///< ρ'(s)
};

// Cauchy: ρ(s) = c² log(1 + s / c²); plain least squares for c = 0.
CornerLoss corner_loss(double s, double scale) {
  if (scale <= 0.0) return {s, 1.0};
  const double ratio = s / (scale * scale);
  return {scale * scale * std::log1p(ratio), 1.0 / (1.0 + ratio)};
}

template <CameraModel M, bool with_shape>
bool fill_rows_of(const ViewData& view, const ViewPoint& point, const MotionMap& map, double robust_scale,
                  ViewRows& rows) {
  constexpr int n = kShapeSize<M>;
  const double* p = point.intrinsics;
  const double* shape = p + 4;
  const Eigen::Vector3d normal = map.camera_from_target.col(2);
  const Eigen::Index stride = rows.u.rows();
  for (int i = 0; i < rows.corners; ++i) {
    Eigen::Vector3d x = view.x_in_target.col(i);
    x.z() += view.shape_basis.col(i).dot(point.shape);
    const Eigen::Vector3d offset = map.camera_from_target * x;  // from the board's origin, in camera axes
    const Eigen::Vector3d ray = offset + map.translation;
    double plane[2];
    double wrt_ray[6];
    double wrt_model_shape[n > 0 ? 2 * n : 1];
    if (!M::plane_from_ray(shape, ray.data(), plane, wrt_ray, wrt_model_shape)) return false;

    double residual[2];
    for (int axis = 0; axis < 2; ++axis) {
      residual[axis] = (p[axis] * plane[axis] + p[2 + axis] - view.pixel(axis, i)) * view.inverse_sigma[i];
    }
    const double s = residual[0] * residual[0] + residual[1] * residual[1];
    const CornerLoss loss = corner_loss(s, robust_scale);
    rows.robust_chi2 += loss.value;
    rows.weighted_chi2 += loss.weight * s;
    const double root = std::sqrt(loss.weight);
    const double scale = root * view.inverse_sigma[i];

    for (int axis = 0; axis < 2; ++axis) {
      double* out = (axis == 0 ? rows.u : rows.v).data() + i;
      const auto put = [&](double value) {
        *out = value;
        out += stride;
      };
      const double focal = scale * p[axis];
      put(scale * plane[axis]);
      put(scale);
      for (int k = 0; k < n; ++k) put(focal * wrt_model_shape[axis * n + k]);
      const Eigen::Vector3d slope(focal * wrt_ray[3 * axis], focal * wrt_ray[3 * axis + 1],
                                  focal * wrt_ray[3 * axis + 2]);
      const Eigen::Vector3d turn = offset.cross(slope);  // slopeᵀ (w × offset) = (offset × slope)ᵀ w
      for (int k = 0; k < 3; ++k) put(turn[k]);
      for (int k = 0; k < 3; ++k) put(slope[k]);
      if constexpr (with_shape) {
        const double along_normal = slope.dot(normal);
        for (int k = 0; k < 3; ++k) put(along_normal * view.shape_basis(k, i));
      }
      put(root * residual[axis]);
    }
  }
  return true;
}

// Two rows at once: what every x86-64 and AArch64 has, so that all machines of a kind add in the same order.
using Lane = double __attribute__((vector_size(16), aligned(8), may_alias));

}  // namespace

MotionMap::MotionMap(const ViewPoint& point)
    : camera_from_rig(point.camera_from_rig.rotation.toRotationMatrix()),
      camera_from_target(camera_from_rig * point.rig_from_target.rotation.toRotationMatrix()),
      arm(camera_from_rig * point.rig_from_target.translation),
      translation(arm + point.camera_from_rig.translation) {}

bool fill_rows(const ViewData& view, const ViewPoint& point, const MotionMap& map, const ViewBlockOptions& options,
               ViewRows& rows) {
  if (!(point.intrinsics[0] > 0.0) || !(point.intrinsics[1] > 0.0)) return false;
  return with_model(view.model, [&]<CameraModel M>() {
    rows.corners = static_cast<int>(view.pixel.cols());
    rows.model_shape_size = kShapeSize<M>;
    rows.with_shape = options.with_shape;
    rows.robust_chi2 = rows.weighted_chi2 = 0.0;
    const int padded = (rows.corners + ViewRows::kRowBlock - 1) / ViewRows::kRowBlock * ViewRows::kRowBlock;
    for (Eigen::MatrixXd* side : {&rows.u, &rows.v}) {
      side->resize(padded, rows.columns());
      side->bottomRows(padded - rows.corners).setZero();
    }
    if (options.with_shape) return fill_rows_of<M, true>(view, point, map, options.robust_scale_sigma, rows);
    return fill_rows_of<M, false>(view, point, map, options.robust_scale_sigma, rows);
  });
}

void gram(const Eigen::MatrixXd& rows, Eigen::MatrixXd& product) {
  const Eigen::Index columns = rows.cols();
  const Eigen::Index stride = rows.rows();
  product.resize(columns, columns);
  const auto lane = [](const double* address) { return *reinterpret_cast<const Lane*>(address); };
  // Blocks of 2×2 columns and two partial sums each: eight independent chains keep the adders busy.
  for (Eigen::Index a = 0; a < columns; a += 2) {
    const double* a0 = rows.data() + a * stride;
    const double* a1 = a + 1 < columns ? a0 + stride : a0;
    for (Eigen::Index b = a; b < columns; b += 2) {
      const double* b0 = rows.data() + b * stride;
      const double* b1 = b + 1 < columns ? b0 + stride : b0;
      Lane sum[2][4] = {};
      for (Eigen::Index i = 0; i < stride; i += ViewRows::kRowBlock) {
        for (int half = 0; half < 2; ++half) {
          const Eigen::Index k = i + 2 * half;
          const Lane x0 = lane(a0 + k), x1 = lane(a1 + k), y0 = lane(b0 + k), y1 = lane(b1 + k);
          sum[half][0] += x0 * y0;
          sum[half][1] += x0 * y1;
          sum[half][2] += x1 * y0;
          sum[half][3] += x1 * y1;
        }
      }
      const auto total = [&](int which) {
        const Lane both = sum[0][which] + sum[1][which];
        return both[0] + both[1];
      };
      product(a, b) = total(0);
      if (b + 1 < columns) product(a, b + 1) = total(1);
      if (a + 1 < columns && b > a) product(a + 1, b) = total(2);
      if (a + 1 < columns && b + 1 < columns) product(a + 1, b + 1) = total(3);
    }
  }
}

}  // namespace raybundle
