// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "raybundle/camera/camera.hpp"
#include "raybundle/geometry/rigid3.hpp"

namespace raybundle {

/// Cameras of the same model with other parameters that put rays nearly where this one puts them. Some models have such
/// twins: a double_sphere lens with xi below zero looks like one with xi above. A solve that starts at one of them does
/// not reach the other, and only their costs tell which is right.
///
/// @param rays_in_camera  where the camera has seen corners
/// @param alike_px        root mean square distance of the projections up to which a camera is a twin
/// @return                those whose parameters are farther away than the projections tell; mostly none
std::vector<Camera> twin_cameras(const Camera& camera, const std::vector<Eigen::Vector3d>& rays_in_camera,
                                 double alike_px);

/// A camera of the same model that puts rays onto pixels as nearly as it can, from the model's own start values: a lens
/// that has lost rays, beyond a pole of its profile say, cannot be moved to where it projects them.
///
/// @param pixels  aligned with rays_in_camera
/// @param zeros   indices of parameters that are held at zero
Camera fitted_anew(const Camera& camera, const std::vector<Eigen::Vector3d>& rays_in_camera,
                   const std::vector<Eigen::Vector2d>& pixels, const std::vector<int>& zeros = {});

/// Cameras of the same model along the one direction of the parameters that the projections tell least of, as far as
/// they put rays nearly where this one puts them. A valley may have several optima: common factors of a rational lens,
/// the two sides of xi = 0 of a double sphere.
///
/// @param alike_px      root mean square distance of the projections, a common turn removed, up to which the
///                      way goes on
/// @param of_each_side  at most so many, the last ones: steps grow, and the first lead back
std::vector<Camera> cameras_along_valley(const Camera& camera, const std::vector<Eigen::Vector3d>& rays_in_camera,
                                         double alike_px, std::size_t of_each_side);

/// The other pose from which a flat board looks nearly the same, refined on the pixels.
struct MirroredPose {
  Rigid3 camera_from_target;
  double squares_ratio = 0.0;  ///< squared distances over those of the given pose; below 1 it fits better
};

/// Small or far boards have a mirrored pose, narrow ones one that is turned about their length, and a solve that starts
/// there stays there. Of those the one that fits best.
///
/// @param points_in_target  N [m]
/// @param pixels            N, same order, without wrong ones
/// @return                  nothing when it plainly does not fit (squares_ratio above 4), the board is not flat, or
///                          the way leads back to the given pose
std::optional<MirroredPose> find_mirrored_pose(const Camera& camera, std::span<const Eigen::Vector3d> points_in_target,
                                               std::span<const Eigen::Vector2d> pixels,
                                               const Rigid3& camera_from_target);

}  // namespace raybundle
