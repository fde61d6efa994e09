// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>

namespace raybundle::apps {

/// A video that is being read.
class VideoReader {
 public:
  virtual ~VideoReader() = default;

  /// @return  the next frame in grey, of 8 bits; empty behind the last one that can be decoded, be there any or not
  virtual cv::Mat next() = 0;
};

/// What OpenCV reads of images and videos. Debian's OpenCV brings some 240 shared libraries for it, whose loading costs
/// 0.1 s and 60 MB, as much as finding the board in thirty images: so it stands in a library of its own, which is loaded
/// when a file is neither a JPEG nor a grey PNG, or is damaged.
class Media {
 public:
  virtual ~Media() = default;

  /// @return  the grey image, with the depth that it has; empty when it is no image. Throws cv::Exception at some
  virtual cv::Mat decode_grey(const std::string& bytes) const = 0;

  /// Whether a file may be an image by what it holds, however it is called.
  virtual bool may_be_image(const std::string& path) const = 0;

  virtual bool reads_videos() const = 0;

  /// Of a file that is no video the first frame is empty.
  virtual std::unique_ptr<VideoReader> open_video(const std::string& path) const = 0;
};

inline constexpr const char* kMediaLibrary = "libraybundle_media.so";

/// The one that the library holds, loaded at the first call.
///
/// @throws Error(kIo) when the library does not lie beside the program
const Media& media();

}  // namespace raybundle::apps
