// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "pose_information.hpp"

#include <Eigen/QR>
#include <algorithm>

#include "sensitivity.hpp"

namespace raybundle {
namespace {

constexpr Eigen::Index kPoseColumns = 6;

Eigen::Index corner_rows(const std::vector<ViewData>& views) {
  Eigen::Index count = 0;
  for (const ViewData& view : views) count += 2 * view.pixel.rows();
  return count;
}

// The columns of the pose, of the parameters that the covariance names and of the residual; zero when a corner does not
// project.
Eigen::MatrixXd whitened_rows(const Calibration& calibration, const std::vector<ViewData>& views,
                              const Rigid3& rig_from_target) {
  const Covariance& known = calibration.covariance;
  const auto parameters = static_cast<Eigen::Index>(known.names.size());
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(corner_rows(views), kPoseColumns + parameters + 1);
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

}  // namespace

Eigen::MatrixXd rows_beside_pose(const Calibration& calibration, const std::vector<ViewData>& views,
                                 const Rigid3& rig_from_target) {
  const Eigen::MatrixXd all = whitened_rows(calibration, views, rig_from_target);
  const Eigen::Index count = all.rows();
  Eigen::MatrixXd rows = all.topRightCorner(count, all.cols() - kPoseColumns);
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(all.topLeftCorner(count, kPoseColumns));
  const Eigen::MatrixXd along = qr.householderQ() * Eigen::MatrixXd::Identity(count, qr.rank());
  rows -= along * (along.transpose() * rows);
  return rows;
}

ViewData used_corners(const CalibrationProblem& problem, const CalibrationResult& result, int view, int camera) {
  TargetView seen = problem.views[view];
  const ViewResult& solved = result.views[view];
  const Target& target = problem.targets[seen.target];
  relabel(target, solved.symmetry, seen.observations);
  for (Observation& corner : seen.observations) corner.sigma_px *= result.cameras[seen.camera].sigma_scale;
  ViewData data = view_data(target, seen, solved.fates);
  data.view = view;
  data.camera = camera;
  data.target = seen.target;
  data.pose = solved.pose;
  data.model = problem.cameras[seen.camera].model;
  return data;
}

}  // namespace raybundle
