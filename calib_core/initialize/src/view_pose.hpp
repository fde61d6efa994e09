// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <optional>
#include <string>

#include "lens_bundle.hpp"
#include "raybundle/scene/problem.hpp"

namespace raybundle {

/// The pose of one view and how well it fits.
struct ViewPose {
  Rigid3 camera_from_target;
  int fitting = 0;                   ///< of the judged corners, those within the threshold
  double median_px = 0.0;            ///< distance of the judged corners; infinite when most are not projected
  std::vector<double> distances_px;  ///< of the judged corners; infinite where one is not projected

  /// Whether it is to be believed: half of the judged corners fit, and four, which fix it.
  bool fits() const { return fitting >= std::max(4, static_cast<int>((distances_px.size() + 1) / 2)); }
};

/// Corners of a view with the points they belong to.
PointsInView points_in_view(const Target& target, const TargetView& view);

/// Robust pose under a known lens: linear on a few corners where some more of them say that it is plainly right, else
/// RANSAC on rays and least squares in pixels, judged by all corners.
std::optional<ViewPose> view_pose(const LensFunctions& lens, const double* parameters, const PointsInView& view,
                                  double threshold_px);

/// The second way of view_pose alone.
std::optional<ViewPose> ransac_view_pose(const LensFunctions& lens, const double* parameters, const PointsInView& view,
                                         double threshold_px);

/// The same pose judged by another threshold.
void judge(ViewPose& pose, double threshold_px);

/// Why a pose that view_pose found (or did not find) is not believed; empty when it is.
std::string reason_against(const std::optional<ViewPose>& pose, const PointsInView& view, double threshold_px);

}  // namespace raybundle
