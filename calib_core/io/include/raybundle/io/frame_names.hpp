// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace raybundle {

/// Names of the frames of one camera's images: the digits in which the file names differ, joined by -, without leading
/// zeros: left03.jpg and left12.jpg are frames 3 and 12. Images whose names hold no such digits are frames by their
/// file name without the extension.
///
/// @param paths  images of one camera; a single image is taken as differing in its last digits
/// @return       aligned with paths
std::vector<std::string> frame_names(const std::vector<std::string>& paths);

/// Whether the file names of two images hold numbers, but none in common: then they are hardly of one moment.
bool numbered_apart(const std::string& path_a, const std::string& path_b);

}  // namespace raybundle
