// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "lens_bundle.hpp"

namespace raybundle {

/// Whether flat boards look as if they all stood parallel to the image: a turn, a scale and a shift alone put almost
/// every view's corners where they are, as well as a lens with poses does. Focal length and distance are then one
/// unknown.
///
/// @param noise_px  mean distance of most corners under the lens and poses that fit best
bool all_parallel_to_image(const std::vector<PointsInView>& views, double noise_px);

}  // namespace raybundle
