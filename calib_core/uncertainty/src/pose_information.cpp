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

PoseInformation pose_information(const Calibration& calibration, const std::vector<ViewData>& views,
                                 const Rigid3& rig_from_target) {
  const Covariance& known = calibration.covariance;
  const auto columns = static_cast<Eigen::Index>(known.names.size());
  PoseInformation sum{Eigen::MatrixXd::Zero(columns, columns), Eigen::VectorXd::Zero(columns)};
  Eigen::Index rows = 0;
  for (const ViewData& view : views) rows += 2 * view.pixel.rows();
  if (rows == 0) return sum;
  Eigen::MatrixXd by_pose(rows, 6), by_all = Eigen::MatrixXd::Zero(rows, columns + 1);  // last column: the residual
  Eigen::Index row = 0;
  for (const ViewData& view : views) {
    const RigCamera& camera = calibration.cameras[view.camera];
    const CalibratedTarget& target = calibration.targets[view.target];
    const BoardShape& shape = target.shape;
    const ViewPoint point{camera.camera.parameters.data(), camera.camera_from_rig, rig_from_target, shape.sags()};
    ViewBlock block;
    if (!linearize_view(view, point, {.with_shape = true}, block)) return sum;
    const Eigen::Index count = 2 * view.pixel.rows();
    by_pose.middleRows(row, count) = block.wrt_rig_from_target.topRows(count);
    auto here = by_all.middleRows(row, count);
    scatter(block.wrt_intrinsics.topRows(count), known.places_of(intrinsic_names(camera)), here);
    scatter(block.wrt_camera_from_rig.topRows(count), known.places_of(extrinsic_names(camera)), here);
    scatter(block.wrt_shape.topRows(count), known.places_of(shape_names(target.target.name)), here);
    here.rightCols<1>() = block.residual.head(count);
    row += count;
  }
  // What is orthogonal to the pose's columns.
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(by_pose);
  by_all.applyOnTheLeft(qr.householderQ().adjoint());
  const auto rest = by_all.bottomRows(rows - qr.rank());
  sum.information = rest.leftCols(columns).transpose() * rest.leftCols(columns);
  sum.gradient = rest.leftCols(columns).transpose() * rest.rightCols<1>();
  return sum;
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
    if (!pixel || pixel->minCoeff() < 0.0) continue;
    if (pixel->x() <= lens.camera.size.width - 1 && pixel->y() <= lens.camera.size.height - 1) seen.push_back(i);
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
