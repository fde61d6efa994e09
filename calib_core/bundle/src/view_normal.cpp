// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "view_normal.hpp"

#include "raybundle/geometry/gram.hpp"

namespace raybundle {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix6X = Eigen::Matrix<double, 6, Eigen::Dynamic>;

}  // namespace

bool accumulate_view(const ViewData& view, const ViewPoint& point, const ViewBlockOptions& options,
                     ViewNormal& normal) {
  thread_local ViewRows rows;
  thread_local Eigen::MatrixXd product;
  if (!fill_rows(view, point, MotionMap(point), options, rows)) return false;
  const int first = options.lens_fixed ? rows.motion() : 0;  // column
  const int left_out = options.lens_fixed ? 4 + rows.model_shape_size : 0;
  const int size = rows.unknowns() + 1 - left_out;
  normal.products.setZero(size, size);
  for (int axis = 0; axis < 2; ++axis) {
    gram(axis == 0 ? rows.u : rows.v, product, first);
    for (int b = first; b < rows.columns(); ++b) {
      double* column = &normal.products(0, ViewRows::full_column(b, axis) - left_out);
      for (int a = first; a <= b; ++a)
        column[ViewRows::full_column(a, axis) - left_out] += product(a - first, b - first);
    }
  }
  normal.chi2 = rows.robust_chi2;
  return true;
}

Eigen::MatrixXd expanded(const Eigen::MatrixXd& products, const MotionMap& map, Eigen::Index intrinsics) {
  const Eigen::Index n = products.cols();
  Eigen::MatrixXd result(n + 6, n + 6);
  result.topLeftCorner(n, n) = products.selfadjointView<Eigen::Upper>();
  const Matrix6 wrt_pose = map.wrt_rig_from_target();
  const Matrix6 wrt_camera = map.wrt_camera_from_rig();
  const Matrix6X rows = result.middleRows<6>(intrinsics).leftCols(n);
  const Matrix6 among = rows.middleCols<6>(intrinsics);
  result.block(intrinsics, 0, 6, n).noalias() = wrt_pose.transpose() * rows;
  result.block(n, 0, 6, n).noalias() = wrt_camera.transpose() * rows;
  result.block<6, 6>(intrinsics, intrinsics) = wrt_pose.transpose() * among * wrt_pose;
  result.block<6, 6>(n, intrinsics) = wrt_camera.transpose() * among * wrt_pose;
  result.block<6, 6>(n, n) = wrt_camera.transpose() * among * wrt_camera;
  result.block(0, intrinsics, n, 6) = result.block(intrinsics, 0, 6, n).transpose().eval();
  result.block(0, n, n, 6) = result.block(n, 0, 6, n).transpose();
  return result;
}

bool multiply_view(const ViewData& view, const ViewPoint& point, const ViewBlockOptions& options,
                   Eigen::MatrixXd& products) {
  thread_local ViewNormal normal;
  if (!accumulate_view(view, point, options, normal)) return false;
  const Eigen::Index columns_behind = 6 + (options.with_shape ? 3 : 0) + 1;
  products = expanded(normal.products, MotionMap(point), normal.products.cols() - columns_behind);
  return true;
}

}  // namespace raybundle
