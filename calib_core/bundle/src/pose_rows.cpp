// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "pose_rows.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>

#include "raybundle/geometry/gram.hpp"
#include "raybundle/geometry/target_clones.hpp"
#include "view_rows.hpp"

namespace raybundle {
namespace {

using Kind = ParameterBlock::Kind;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix6X = Eigen::Matrix<double, 6, Eigen::Dynamic>;

constexpr double kPlainlySeen = 1e-3;  // pivot, over the length of its column: so far normal equations tell the pose

// Writes a view's rows, one axis after the other: the pose's six columns, the free parameters, the residual.
void append(const ViewRows& rows, const MotionMap& map, const ViewData& view, const Layout& layout, Eigen::Index first,
            Eigen::MatrixXd& all) {
  const std::vector<int> intrinsics = layout.columns_of(Kind::kIntrinsics, view.camera);
  const std::vector<int> extrinsics = layout.columns_of(Kind::kCameraFromRig, view.camera);
  const std::vector<int> shape = layout.columns_of(Kind::kShape, view.target);
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::MatrixXd& side = axis == 0 ? rows.u : rows.v;
    auto here = all.middleRows(first + axis * side.rows(), side.rows());
    const auto motion = side.middleCols<6>(rows.motion());
    here.leftCols<6>().noalias() = motion * map.wrt_rig_from_target();
    const auto put = [&](int column, const auto& values) {
      if (column >= 0) here.col(6 + column) = values;
    };
    for (int k = 0; k < rows.motion(); ++k) put(intrinsics[ViewRows::full_column(k, axis)], side.col(k));
    const Matrix6 by_camera = map.wrt_camera_from_rig();
    for (int k = 0; k < 6; ++k) put(extrinsics[k], motion * by_camera.col(k));
    for (int k = 0; k < (rows.with_shape ? 3 : 0); ++k) put(shape[k], side.col(rows.motion() + 6 + k));
    here.rightCols<1>() = side.rightCols<1>();
  }
}

// Takes the combinations of the first six columns out of the others.
RAYBUNDLE_TARGET_CLONES
void subtract(const Matrix6X& combinations, Eigen::MatrixXd& all) {
  const Eigen::Index stride = all.rows();
  const double* first = all.data();
  for (Eigen::Index column = 0; column < combinations.cols(); ++column) {
    const double* weight = &combinations(0, column);
    double* to = &all(0, 6 + column);
    for (Eigen::Index i = 0; i < stride; ++i) {
      double sum = to[i];
      for (int k = 0; k < 6; ++k) sum -= weight[k] * first[i + k * stride];
      to[i] = sum;
    }
  }
}

// By orthogonal rotations, also where the pose is not seen in all directions: three when all points are infinitely far.
void eliminate_by_rotations(const Eigen::MatrixXd& all, PoseEquations& equations) {
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(all.leftCols<6>());
  Eigen::MatrixXd rotated = all.rightCols(all.cols() - 6);
  rotated.applyOnTheLeft(qr.householderQ().adjoint());
  const auto left = rotated.bottomRows(rotated.rows() - qr.rank());
  equations.directions = static_cast<int>(qr.rank());
  equations.left = left.transpose() * left;
}

// What is left of the rows when the pose follows: their part that is orthogonal to its columns. It is taken from the
// rows themselves, not from their products, which would be a difference of large matrices: an unseen direction comes
// out as such. The normal equations leave a little of the pose in the rows, and taking that out is a small correction.
void eliminate(Eigen::MatrixXd& all, PoseEquations& equations) {
  const Eigen::Index others = all.cols() - 6;
  thread_local Eigen::MatrixXd products;
  gram(all, products);
  equations.chi2 = products(all.cols() - 1, all.cols() - 1);
  const Matrix6 own = products.topLeftCorner<6, 6>().selfadjointView<Eigen::Upper>();
  const Eigen::LLT<Matrix6> factor(own);
  const Eigen::Array<double, 6, 1> pivots = factor.matrixLLT().diagonal();
  if (factor.info() != Eigen::Success || !(pivots > kPlainlySeen * own.diagonal().array().sqrt()).all()) {
    eliminate_by_rotations(all, equations);
    return;
  }
  subtract(factor.solve(products.topRightCorner(6, others)), all);
  gram(all, products);
  const Matrix6X across = products.topRightCorner(6, others);
  equations.left = products.bottomRightCorner(others, others);
  equations.left.noalias() -= across.transpose().lazyProduct(factor.solve(across));
  equations.directions = 6;
}

}  // namespace

int eliminate_pose(const std::vector<ViewData>& views, const Unknowns& unknowns, const Layout& layout,
                   double robust_scale_sigma, PoseEquations& equations) {
  thread_local ViewRows rows;
  thread_local Eigen::MatrixXd all;
  Eigen::Index count = 0;
  for (const ViewData& view : views) count += 2 * padded_for_gram(view.pixel.rows());
  all.setZero(count, 6 + layout.columns + 1);
  Eigen::Index first = 0;
  for (const ViewData& view : views) {
    const ViewPoint point = unknowns.at(view);
    const MotionMap map(point);
    const ViewBlockOptions options{.with_shape = layout.estimates_shape(view.target),
                                   .robust_scale_sigma = robust_scale_sigma};
    if (!fill_rows(view, point, map, options, rows)) return view.view;
    append(rows, map, view, layout, first, all);
    first += 2 * rows.u.rows();
    equations.residuals += 2 * rows.corners;
  }
  eliminate(all, equations);
  return -1;
}

}  // namespace raybundle
