// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "lens_bundle.hpp"

namespace raybundle {

/// Parameters of a camera model that put rays where they were seen: fitted from the model's start and example shapes,
/// the best kept. Rays that the model cannot project do not count; a model that cannot describe the lens gets its best
/// fit.
///
/// @param field  rays in the camera (as points) and their pixels
/// @param zeros  indices of parameters that are held at zero
LensVector fit_model(ModelId model, const PointsInView& field, const LensVector& guess_fx_fy_cx_cy,
                     const std::vector<int>& zeros = {});

/// The same from each of the model's start and example shapes and from near and far of a lens that is known: all the
/// ways in which the model can describe it.
std::vector<LensVector> model_fits(ModelId model, const PointsInView& field, const LensVector& known);

/// At most `count` of the rays that a camera projects, with their pixels; none when fewer than 20 are left to compare
/// lenses on.
PointsInView field_seen(const Camera& camera, const std::vector<Eigen::Vector3d>& rays_in_camera, std::size_t count);

/// Weak priors towards the model's start shape, so that terms that the data does not show stay small.
LensBundleOptions model_options(ModelId model, const LensVector& mean, double scale_px);

}  // namespace raybundle
