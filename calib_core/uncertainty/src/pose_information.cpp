// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "pose_information.hpp"

#include <Eigen/QR>
#include <algorithm>

#include "sensitivity.hpp"

namespace raybundle {
namespace {

ViewData view_of(int camera, int target, ModelId model, Eigen::Index rows) {
  ViewData view;
  view.camera = camera;
  view.target = target;
  view.model = model;
  view.x_in_target.resize(rows, 3);
  view.nearness.setOnes(rows);
  view.shape_basis.resize(rows, 3);
  view.pixel.setZero(rows, 2);
  view.inverse_sigma.resize(rows);
  return view;
}

}  // namespace

Eigen::MatrixXd rows_beside_pose(const Calibration& calibration, const std::vector<ViewData>& views,
                                 const Rigid3& rig_from_target) {
  const Covariance& known = calibration.covariance;
  const auto columns = static_cast<Eigen::Index>(known.names.size());
  Eigen::Index count = 0;
  for (const ViewData& view : views) count += 2 * view.pixel.rows();
  Eigen::MatrixXd by_pose(count, 6), rows = Eigen::MatrixXd::Zero(count, columns + 1);
  Eigen::Index first = 0;
  for (const ViewData& view : views) {
    const RigCamera& camera = calibration.cameras[view.camera];
    const CalibratedTarget& target = calibration.targets[view.target];
    const BoardShape& shape = target.shape;
    const ViewPoint point{camera.camera.parameters.data(), camera.camera_from_rig, rig_from_target, shape.sags()};
    ViewBlock block;
    if (!linearize_view(view, point, {.with_shape = true}, block)) return Eigen::MatrixXd::Zero(count, columns + 1);
    const Eigen::Index of_view = 2 * view.pixel.rows();
    by_pose.middleRows(first, of_view) = block.wrt_rig_from_target.topRows(of_view);
    auto here = rows.middleRows(first, of_view);
    scatter(block.wrt_intrinsics.topRows(of_view), known.places_of(intrinsic_names(camera)), here);
    scatter(block.wrt_camera_from_rig.topRows(of_view), known.places_of(extrinsic_names(camera)), here);
    scatter(block.wrt_shape.topRows(of_view), known.places_of(shape_names(target.target.name)), here);
    here.rightCols<1>() = block.residual.head(of_view);
    first += of_view;
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(by_pose);
  const Eigen::MatrixXd along = qr.householderQ() * Eigen::MatrixXd::Identity(count, qr.rank());
  rows -= along * (along.transpose() * rows);
  return rows;
}

PoseInformation pose_information(const Calibration& calibration, const std::vector<ViewData>& views,
                                 const Rigid3& rig_from_target) {
  const Eigen::MatrixXd rows = rows_beside_pose(calibration, views, rig_from_target);
  const auto by_parameters = rows.leftCols(rows.cols() - 1);
  return {by_parameters.transpose() * by_parameters, by_parameters.transpose() * rows.rightCols<1>()};
}

ViewData used_corners(const CalibrationProblem& problem, const CalibrationResult& result, int view, int camera) {
  const TargetView& seen = problem.views[view];
  const ViewResult& solved = result.views[view];
  const Target& target = problem.targets[seen.target];
  const std::vector<Eigen::Vector3d> basis = shape_basis(target);
  const auto used = std::ranges::count(solved.fates, ObservationFate::kUsed);
  ViewData data = view_of(camera, seen.target, problem.cameras[seen.camera].model, used);
  data.view = view;
  data.pose = solved.pose;
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < seen.observations.size(); ++i) {
    if (solved.fates[i] != ObservationFate::kUsed) continue;
    const Observation& observation = seen.observations[i];
    auto point = target.find(observation.point_id) - target.points.data();
    if (solved.symmetry >= 0) {
      point = target.find(target.symmetries[solved.symmetry].ids[point]) - target.points.data();
    }
    data.x_in_target.row(row) = target.points[point].x_in_target.transpose();
    data.shape_basis.row(row) = basis[point].transpose();
    data.pixel.row(row) = observation.pixel.transpose();
    data.inverse_sigma[row++] = 1.0 / observation.sigma_px;
  }
  return data;
}

ViewData imagined_corners(const Calibration& calibration, int camera, int target, const Rigid3& rig_from_target,
                          double sigma_px) {
  const RigCamera& lens = calibration.cameras[camera];
  const CalibratedTarget& board = calibration.targets[target];
  const std::vector<Eigen::Vector3d> basis = shape_basis(board.target);
  const std::vector<Eigen::Vector3d> surface = points_on_surface(board.target, board.shape);
  const Rigid3 camera_from_target = lens.camera_from_rig * rig_from_target;
  std::vector<std::size_t> seen;
  for (std::size_t i = 0; i < surface.size(); ++i) {
    const auto pixel = pixel_from_ray(lens.camera, camera_from_target * surface[i]);
    if (pixel && lens.camera.size.contains(*pixel)) seen.push_back(i);
  }
  ViewData data = view_of(camera, target, lens.camera.model, static_cast<Eigen::Index>(seen.size()));
  data.inverse_sigma.setConstant(1.0 / sigma_px);
  for (std::size_t k = 0; k < seen.size(); ++k) {
    data.x_in_target.row(static_cast<Eigen::Index>(k)) = board.target.points[seen[k]].x_in_target.transpose();
    data.shape_basis.row(static_cast<Eigen::Index>(k)) = basis[seen[k]].transpose();
  }
  return data;
}

}  // namespace raybundle
