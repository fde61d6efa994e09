// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "pose_information.hpp"

#include <Eigen/QR>
#include <algorithm>

#include "raybundle/geometry/gram.hpp"
#include "sensitivity.hpp"

namespace raybundle {
namespace {

constexpr Eigen::Index kPoseColumns = 6;
constexpr double kUnseen = 1e-12;  // of the largest: directions of a pose that its corners do not tell

Eigen::Index corner_rows(const std::vector<ViewData>& views) {
  Eigen::Index count = 0;
  for (const ViewData& view : views) count += 2 * view.pixel.rows();
  return count;
}

// The columns of the pose, of the parameters that the covariance names and of the residual. Behind the rows of the
// corners stand zeros, as gram() wants them; all are zero when a corner does not project.
Eigen::MatrixXd whitened_rows(const Calibration& calibration, const std::vector<ViewData>& views,
                              const Rigid3& rig_from_target) {
  const Covariance& known = calibration.covariance;
  const auto parameters = static_cast<Eigen::Index>(known.names.size());
  const Eigen::Index padded = padded_for_gram(corner_rows(views));
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(padded, kPoseColumns + parameters + 1);
  Eigen::Index first = 0;
  for (const ViewData& view : views) {
    const RigCamera& camera = calibration.cameras[view.camera];
    const CalibratedTarget& target = calibration.targets[view.target];
    const ViewPoint point{camera.camera.parameters.data(), camera.camera_from_rig, rig_from_target,
                          target.shape.sags()};
    ViewBlock block;
    if (!linearize_view(view, point, {.with_shape = true}, block)) return rows.setZero();
    const Eigen::Index of_view = 2 * view.pixel.rows();
    rows.block(first, 0, of_view, kPoseColumns) = block.wrt_rig_from_target.topRows(of_view);
    auto here = rows.block(first, kPoseColumns, of_view, parameters);
    scatter(block.wrt_intrinsics.topRows(of_view), known.places_of(intrinsic_names(camera)), here);
    scatter(block.wrt_camera_from_rig.topRows(of_view), known.places_of(extrinsic_names(camera)), here);
    scatter(block.wrt_shape.topRows(of_view), known.places_of(shape_names(target.target.name)), here);
    rows.rightCols<1>().segment(first, of_view) = block.residual.head(of_view);
    first += of_view;
  }
  return rows;
}

// Of the pose's equations, the upper triangle of whose left side stands first in `products`, in units of what each
// direction would be known to alone.
Eigen::MatrixXd pose_solution(const Eigen::MatrixXd& products, const Eigen::MatrixXd& right) {
  using Matrix6d = Eigen::Matrix<double, kPoseColumns, kPoseColumns>;
  const Matrix6d left = products.topLeftCorner<kPoseColumns, kPoseColumns>().selfadjointView<Eigen::Upper>();
  const Eigen::Matrix<double, kPoseColumns, 1> scale =
      (left.diagonal().array() > 0.0).select(left.diagonal().array().rsqrt(), 0.0);
  Eigen::ColPivHouseholderQR<Matrix6d> qr;
  qr.setThreshold(kUnseen);
  qr.compute(scale.asDiagonal() * left * scale.asDiagonal());
  return scale.asDiagonal() * qr.solve(scale.asDiagonal() * right);
}

}  // namespace

Eigen::MatrixXd rows_beside_pose(const Calibration& calibration, const std::vector<ViewData>& views,
                                 const Rigid3& rig_from_target) {
  const Eigen::MatrixXd all = whitened_rows(calibration, views, rig_from_target);
  const Eigen::Index count = corner_rows(views);
  Eigen::MatrixXd rows = all.topRightCorner(count, all.cols() - kPoseColumns);
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(all.topLeftCorner(count, kPoseColumns));
  const Eigen::MatrixXd along = qr.householderQ() * Eigen::MatrixXd::Identity(count, qr.rank());
  rows -= along * (along.transpose() * rows);
  return rows;
}

Eigen::MatrixXd pose_information(const Calibration& calibration, const std::vector<ViewData>& views,
                                 const Rigid3& rig_from_target) {
  Eigen::MatrixXd products;
  gram(whitened_rows(calibration, views, rig_from_target), products);
  const auto parameters = static_cast<Eigen::Index>(calibration.covariance.names.size());
  const Eigen::MatrixXd across = products.block(0, kPoseColumns, kPoseColumns, parameters);
  Eigen::MatrixXd information =
      products.block(kPoseColumns, kPoseColumns, parameters, parameters).selfadjointView<Eigen::Upper>();
  information.noalias() -= across.transpose() * pose_solution(products, across);
  return information;
}

ViewData used_corners(const CalibrationProblem& problem, const CalibrationResult& result, int view, int camera) {
  const TargetView& seen = problem.views[view];
  const ViewResult& solved = result.views[view];
  const Target& target = problem.targets[seen.target];
  const auto count = std::ranges::count(solved.fates, ObservationFate::kUsed);
  ViewData data{.view = view,
                .camera = camera,
                .target = seen.target,
                .pose = solved.pose,
                .model = problem.cameras[seen.camera].model,
                .points = {},
                .pixel = Eigen::MatrixX2d(count, 2),
                .inverse_sigma = Eigen::ArrayXd(count)};
  std::vector<int> used;  // of the target's points
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < seen.observations.size(); ++i) {
    if (solved.fates[i] != ObservationFate::kUsed) continue;
    const Observation& observation = seen.observations[i];
    auto point = target.find(observation.point_id) - target.points.data();
    if (solved.symmetry >= 0) {
      point = target.find(target.symmetries[solved.symmetry].ids[point]) - target.points.data();
    }
    used.push_back(static_cast<int>(point));
    data.pixel.row(row) = observation.pixel.transpose();
    data.inverse_sigma[row++] = 1.0 / observation.sigma_px;
  }
  data.points = std::make_shared<BoardPoints>(target, shape_basis(target), used);
  return data;
}

ViewData imagined_corners(const Calibration& calibration, int camera, int target, const Rigid3& rig_from_target,
                          double sigma_px) {
  const RigCamera& lens = calibration.cameras[camera];
  const CalibratedTarget& board = calibration.targets[target];
  const std::vector<Eigen::Vector3d> surface = points_on_surface(board.target, board.shape);
  const Rigid3 camera_from_target = lens.camera_from_rig * rig_from_target;
  std::vector<int> seen;
  for (std::size_t i = 0; i < surface.size(); ++i) {
    const auto pixel = pixel_from_ray(lens.camera, camera_from_target * surface[i]);
    if (pixel && lens.camera.size.contains(*pixel)) seen.push_back(static_cast<int>(i));
  }
  const auto count = static_cast<Eigen::Index>(seen.size());
  return {.view = 0,
          .camera = camera,
          .target = target,
          .pose = 0,
          .model = lens.camera.model,
          .points = std::make_shared<BoardPoints>(board.target, shape_basis(board.target), seen),
          .pixel = Eigen::MatrixX2d::Zero(count, 2),
          .inverse_sigma = Eigen::ArrayXd::Constant(count, 1.0 / sigma_px)};
}

}  // namespace raybundle
