// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>

namespace raybundle::apps {

/// Undoes the filters of a PNG's rows of one byte a pixel: each byte is the difference from what its neighbours to the
/// left and above predict.
///
/// @param filtered  for each row a byte that names its filter, 0 to 4, then the row
/// @param image     8-bit single channel, of the size wanted
/// @return          false when a filter does not exist
/// Source: W3C, Portable Network Graphics (PNG) Specification, section 9
bool undo_png_filters(const std::uint8_t* filtered, cv::Mat& image);

}  // namespace raybundle::apps
