// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>

#include "raybundle/uncertainty/comparison.hpp"

namespace raybundle {

/// Where a lens sees a ray, and how that moves with the ray.
struct SeenRay {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3> by_ray;
};
using Lens = std::function<std::optional<SeenRay>(const Eigen::Vector3d& ray)>;

/// One camera of two calibrations, at one range.
///
/// @param covariance_a, covariance_b  what sigmas come from
/// @throws Error(kBadInput) when neither holds its CornerEvidence
ProjectionDifference projection_difference(const RigCamera& camera_a, const Covariance& covariance_a,
                                           const RigCamera& camera_b, const Covariance& covariance_b, double range_m,
                                           int columns);

/// The same, at infinity, of a camera and a lens of any kind that was solved for from the same corners. The lens is
/// taken to be as uncertain as the camera. Where it sees nothing, it has no opinion: no cell is lost.
ProjectionDifference projection_difference(const RigCamera& a, const Covariance& covariance_a, const Lens& b,
                                           int columns);

/// What is left of a difference when a known one, of the same cells, is taken off.
ProjectionDifference less(ProjectionDifference difference, const ProjectionDifference& known);

}  // namespace raybundle
