// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include "random_rig.hpp"

namespace raybundle::bench {

/// Whether OpenCV has a solver for the model: cv::calibrateCamera or cv::fisheye::calibrate.
bool opencv_has(std::string_view model);

/// What OpenCV's solver makes of the rig, with its own start values; nothing when it throws.
///
/// @param right_only  without the corners that are known to be wrong
std::optional<BundleState> calibrate_with_opencv(const testing::RandomRig& rig, bool right_only);

}  // namespace raybundle::bench
