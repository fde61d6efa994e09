// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "lens_bundle.hpp"

namespace raybundle {

/// A lens with the board poses that go with it.
struct LensGuess {
  LensVector parameters;
  std::vector<Rigid3> poses;  ///< camera_from_target, aligned with the views
  double score_px = 0.0;      ///< how far corners are off, without the worst corners and views

  /// Of a robust loss: right corners of a lens that is not yet right lie within it.
  double loss_scale_px() const { return std::max(1.5, 4.0 * score_px); }
};

/// How well a lens and its poses explain the views [px]: mean over the best 70 % of views of the mean over the best
/// 80 % of their corners. Wrong corners and wrong views do not count, and there is no reward for leaving a corner out.
double robust_score(const LensFunctions& lens, const double* parameters, const std::vector<PointsInView>& views,
                    const std::vector<Rigid3>& poses);

/// StartLenses of the views: a sweep over focal lengths and profiles, from 30° to beyond 220°, with a linear pose for
/// every view, then those that fit best refined with principal point, aspect ratio and a bent profile. Of those that
/// differ the best ones, the best first: boards that are far away or held alike fit several. Scores tell how far to
/// trust them.
///
/// @param views  a selection: a dozen or two that differ, a few dozen corners in each, gross errors removed
std::vector<LensGuess> search_lenses(const std::vector<PointsInView>& views, ImageSize size);

/// The best of them by a coarser sweep over a handful of the views; nothing unless the lens that it finds explains the
/// views to about a pixel. Ordinary data pass, and cost a tenth.
std::optional<LensGuess> search_lens_quickly(const std::vector<PointsInView>& views, ImageSize size);

/// Relative standard deviation of the focal length when the poses and the profile are unknown too; large when all
/// boards are parallel to the image, so that focal length and distance cannot be told apart.
double focal_uncertainty(const std::vector<PointsInView>& views, ImageSize size, const LensGuess& guess);

}  // namespace raybundle
