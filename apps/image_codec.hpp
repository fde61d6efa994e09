// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <string>
#include <string_view>

namespace raybundle::apps {

/// The grey image in the bytes of a file, with the depth that it has; empty when they are no image. JPEG and grey PNG
/// are decoded here, all else, and what seems damaged, by media().
///
/// @throws cv::Exception of some that are damaged; Error(kIo) as media(), and of DICOM
cv::Mat decoded_grey(const std::string& bytes);

/// Whether the bytes of a file begin as those of a JPEG, or of a PNG.
bool is_jpeg(std::string_view bytes);
bool is_png(std::string_view bytes);

/// Whether the end of a JPEG or PNG is missing: decoders fill what is missing with grey and go on.
bool is_cut_off(std::string_view bytes);

/// Whether they begin as those of a medical image in DICOM, which is never read: the decoder that OpenCV has for it ends
/// the program where it doubts what follows.
bool is_dicom(std::string_view bytes);

inline constexpr std::size_t kLongestSignature = 132;  ///< bytes of a file that say of which of these kinds it is

/// @param image  grey of 8 or 16 bits, or blue, green, red of 8
/// @throws Error(kIo) when it cannot be made a PNG, as one without pixels
std::string png_from(const cv::Mat& image);

/// @param image    grey or blue, green, red, of 8 bits
/// @param quality  1 to 100
/// @throws Error(kIo) when it cannot be made a JPEG, as one without pixels
std::string jpeg_from(const cv::Mat& image, int quality = 95);

}  // namespace raybundle::apps
