// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <string_view>

namespace raybundle::apps {

/// The pixels as the file stores them. OpenCV turns what it reads from a TIFF by the file's orientation, whatever it is
/// asked for; a camera's pixels do not move because it was held upside down.
///
/// @param bytes    of the file, of any format
/// @param decoded  by OpenCV
cv::Mat as_stored(std::string_view bytes, const cv::Mat& decoded);

}  // namespace raybundle::apps
