// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "random_rig.hpp"

namespace raybundle::bench {

/// Whether mrcal has the model.
bool mrcal_has(std::string_view model);

/// What mrcal makes of the rigs without the corners that are known to be wrong, in the steps of its program
/// mrcal-calibrate-cameras and given the focal length of the stereographic lens that draws the image as large. Nothing
/// for a rig when it gives up. Through mrcal's Python API in another process; that Python has mrcal is taken for
/// granted only where `mrcal_is_there()`.
///
/// @param rigs  all of one model
std::vector<std::optional<BundleState>> calibrate_with_mrcal(const std::vector<testing::RandomRig>& rigs);

bool mrcal_is_there();

}  // namespace raybundle::bench
