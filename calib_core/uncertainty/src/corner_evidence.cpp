// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/corner_evidence.hpp"

#include <algorithm>
#include <cmath>

#include "motion_fit.hpp"
#include "raybundle/bundle/view_block.hpp"
#include "raybundle/geometry/rotation.hpp"

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
  ViewBlock block;
  bool any = false;
  for (const ViewData& view : used_views(problem, state)) {
    if (view.camera != camera) continue;
    const BoardShape& shape = state.shapes[view.target];
    const ViewPoint point{lens.parameters.data(), state.camera_from_rig[camera], state.poses[view.pose].rig_from_target,
                          shape.sags()};
    if (!linearize_view(view, point, {}, block)) continue;
    const Eigen::Index rows = 2 * view.pixel.rows();
    fit.add(block.wrt_camera_from_rig.topRows(rows), block.wrt_intrinsics.topRows(rows));
    for (Eigen::Index i = 0; i < view.pixel.rows(); ++i) {
      if (const std::optional<int> cell = evidence.cell(lens.size, view.pixel.row(i))) ++evidence.corners[*cell];
    }
    any = true;
  }
  if (!any) return std::nullopt;
  // The surroundings turn about the camera; camera_from_rig's own motion turns them about the rig's origin.
  Eigen::Matrix<double, 6, 6> map = Eigen::Matrix<double, 6, 6>::Identity();
  map.bottomLeftCorner<3, 3>() = -skew(state.camera_from_rig[camera].translation);
  fit.change_motion(map);
  evidence.implied_motion = fit.undoing();
  return evidence;
}

}  // namespace raybundle
