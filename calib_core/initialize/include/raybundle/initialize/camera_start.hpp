// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "raybundle/camera/camera.hpp"
#include "raybundle/scene/problem.hpp"

namespace raybundle {

/// Start values of one camera: good enough for the bundle to converge from.
struct CameraStart {
  Camera camera;  ///< of the problem's model
  std::vector<std::optional<Rigid3>>
      camera_from_target;            ///< aligned with problem.views; empty for other cameras' views
  std::vector<std::string> reasons;  ///< aligned with problem.views; why a view of this camera has no pose
  std::vector<CameraStart> others;   ///< other lenses, nearly as good: boards that are held alike fit several
};

/// Intrinsics and board poses of a camera from its views alone: no focal guess, any field of view up to beyond 200°,
/// any model of the list, full or partial boards, with wrong corners and whole wrong views among them.
/// Uses problem.cameras[camera].parameters as the start instead when they are given.
///
/// @param threads  change the time, never the bits
/// @throws Error(kNotEnoughData) when fewer than three views are usable, or when they cannot determine the focal length
///         (all parallel to the image plane); the message says which. Not where a start is given: views that do not fit
///         it have no pose, and their reason
CameraStart initialize_camera(const CalibrationProblem& problem, int camera, int threads = 1);

/// Poses of views under a known camera, robustly; the way back for views that were set aside.
///
/// @param fit_px  a right corner lies within this
/// @return        camera_from_target; nothing, with `reason` set, when the view does not fit
std::optional<Rigid3> initialize_view(const CalibrationProblem& problem, const TargetView& view, const Camera& camera,
                                      std::string& reason, double fit_px = 3.0);

}  // namespace raybundle
