// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/camera/camera_difference.hpp"

namespace raybundle {

/// The camera of another model that puts rays nearest, in least squares, to where a camera has them. Its own frame
/// stays: no turn is taken out, so that the rig stays where it is.
///
/// @param rays   of the camera, see rays_over_image. Leave out those that the model has no place for, as beyond 90 degrees
///               for a rational one: with them what is returned is a robust fit of some rays, pixels off
/// @param camera  that they are of
/// @param zeros  indices of parameters of the model that are held at zero
Camera nearest_camera(const std::vector<PixelRay>& rays, const Camera& camera, ModelId model,
                      const std::vector<int>& zeros = {});

}  // namespace raybundle
