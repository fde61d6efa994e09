// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/corner_evidence.hpp"

#include <algorithm>
#include <cmath>

#include "motion_fit.hpp"
#include "raybundle/bundle/view_block.hpp"
#include "sensitivity.hpp"

namespace raybundle {
namespace {

CornerEvidence empty_evidence(ImageSize size) {
  const double cell_px = static_cast<double>(std::max(size.width, size.height)) / kEvidenceCells;
  CornerEvidence evidence;
  evidence.columns = static_cast<int>(std::max(1L, std::lround(size.width / cell_px)));
  evidence.rows = static_cast<int>(std::max(1L, std::lround(size.height / cell_px)));
  evidence.corners.assign(static_cast<std::size_t>(evidence.columns) * evidence.rows, 0);
  return evidence;
}

}  // namespace

std::optional<CornerEvidence> corner_evidence(const CalibrationProblem& problem, const BundleState& state, int camera) {
  const Camera& lens = state.cameras[camera];
  CornerEvidence evidence = empty_evidence(lens.size);
  MotionFit fit(lens.parameters.size());
  bool any = false;
  for (const ViewData& view : used_views(problem, state)) {
    if (view.camera != camera) continue;
    const Rigid3 camera_from_target = state.camera_from_rig[camera] * state.poses[view.pose].rig_from_target;
    const BoardShape& shape = state.shapes[view.target];
    const Eigen::Vector3d sags(shape.bend_x_m, shape.bend_y_m, shape.twist_m);
    for (Eigen::Index i = 0; i < view.pixel.rows(); ++i) {
      Eigen::Vector3d x_in_target = view.x_in_target.row(i);
      x_in_target.z() += view.shape_basis.row(i).dot(sags);
      const Eigen::Vector3d x_in_camera =
          camera_from_target.rotation * x_in_target + view.nearness[i] * camera_from_target.translation;
      const std::optional<PixelDerivatives> derivatives = pixel_derivatives(lens, x_in_camera);
      if (!derivatives) continue;
      Eigen::Matrix<double, 3, 6> motion = by_motion_of_surroundings(x_in_camera);
      motion.rightCols<3>() *= view.nearness[i];
      fit.add(derivatives->by_ray * motion, derivatives->by_intrinsics, view.inverse_sigma[i] * view.inverse_sigma[i]);
      if (const std::optional<int> cell = evidence.cell(lens.size, view.pixel.row(i))) ++evidence.corners[*cell];
      any = true;
    }
  }
  if (!any) return std::nullopt;
  evidence.implied_motion = fit.undoing();
  return evidence;
}

}  // namespace raybundle
