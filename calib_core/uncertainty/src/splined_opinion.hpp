// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mrcal_solve.hpp"
#include "raybundle/scene/result.hpp"
#include "raybundle/uncertainty/second_opinion.hpp"

namespace raybundle {

/// mrcal's solve with its splined stereographic lenses, one for each camera: a grid of knots over the image instead of
/// a formula, so that it is independent of every central lens model.
///
/// The field reaches a little farther than the corners that were used. There are as many knots as keep at least
/// kCornersPerCell corners of each camera, on average, for each cell between them, but neither fewer than follow a lens
/// nor more than mrcal's own studies use. It starts from stereographic lenses, to which it has first fitted focal
/// length, centre and poses. What is compared is where corners surround a ray within one and a half knots: elsewhere
/// the spline is only continued.
///
/// @param request  as mrcal_request
/// @param first    of the same rig and corners, with CornerEvidence
SecondOpinion splined_opinion(const MrcalProblem& request, const Calibration& first);

/// Corners that carry a cell of the spline.
inline constexpr double kCornersPerCell = 16.0;

}  // namespace raybundle
