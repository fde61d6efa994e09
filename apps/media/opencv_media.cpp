// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdlib>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <opencv2/videoio/registry.hpp>
#include <vector>

#include "media.hpp"

namespace raybundle::apps {
namespace {

// Of OpenCV's readers the one for files; others look for cameras on the USB when a file is no video. What is wrong with
// a file the caller says; ffmpeg is to be quiet unless somebody asks it to speak.
class OpencvVideo : public VideoReader {
 public:
  explicit OpencvVideo(const std::string& path) {
    constexpr const char* kQuiet = "-8";
    setenv("OPENCV_FFMPEG_LOGLEVEL", kQuiet, 0);
    video_.open(path, cv::CAP_FFMPEG);
  }

  cv::Mat next() override {
    cv::Mat grey;
    if (video_.read(image_)) cv::cvtColor(image_, grey, cv::COLOR_BGR2GRAY);
    return grey;
  }

 private:
  cv::VideoCapture video_;
  cv::Mat image_;
};

class OpencvMedia : public Media {
 public:
  cv::Mat decode_grey(const std::string& bytes) const override {
    const cv::Mat row(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data()));
    cv::Mat image = cv::imdecode(row, cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH | cv::IMREAD_IGNORE_ORIENTATION);
    if (image.channels() == 3) cv::cvtColor(image, image, cv::COLOR_BGR2GRAY);  // of Radiance's files
    return image;
  }

  bool may_be_image(const std::string& path) const override { return cv::haveImageReader(path); }

  bool reads_videos() const override {
    const std::vector<cv::VideoCaptureAPIs> backends = cv::videoio_registry::getStreamBackends();
    return std::ranges::find(backends, cv::CAP_FFMPEG) != backends.end();
  }

  std::unique_ptr<VideoReader> open_video(const std::string& path) const override {
    return std::make_unique<OpencvVideo>(path);
  }
};

}  // namespace
}  // namespace raybundle::apps

extern "C" const raybundle::apps::Media* raybundle_media() {
  static const raybundle::apps::OpencvMedia media;
  return &media;
}
