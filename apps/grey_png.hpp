// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <string_view>

namespace raybundle::apps {

/// Grey values of a PNG of 8 bits whose rows come one after the other, as cameras and tools write them: three times as
/// fast as libpng.
///
/// @return  empty for every other PNG and for a damaged one: libpng reads it, or says what is wrong
cv::Mat grey_of_plain_png(std::string_view bytes);

/// Whether the chunks that make up the image of a PNG are all there with the checksums that they should have: no decoder
/// takes others.
bool is_sound_png(std::string_view bytes);

}  // namespace raybundle::apps
