// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace raybundle::apps {

/// A self-contained page about one image of laser dots: the image with the labels, the points and their mesh to be
/// turned by hand, and both from the side.
///
/// @param json  of laser_frame_files
/// @param jpeg  the image
std::string laser_page(std::string_view json, std::string_view jpeg);

}  // namespace raybundle::apps
