// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <initializer_list>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace raybundle::apps {

/// One file of a camera: an image, or a video whose frames are numbered from 0.
struct ImageFile {
  int camera = 0;
  std::string path;
  std::string frame;  ///< name of the moment; empty for a video, the file's whole name when it is no image
  bool video = false;
  std::string sha256 = {};  ///< of its content; empty as long as nobody has asked
};

/// Sorts names as a person would count them: numbers in numeric order.
void sort_by_number(std::vector<std::string>& names);

/// Files that match the patterns, sorted by name with numbers in numeric order.
///
/// @throws Error(kIo) when a pattern matches nothing: names the pattern and the folder, and what is there instead
std::vector<std::string> matching_files(const std::string& folder, const std::vector<std::string>& patterns);

/// The image files of one camera with their frame names, and those that match but are no images: they are told.
///
/// @throws Error(kBadInput) when two files would be the same frame
std::vector<ImageFile> image_files(int camera, const std::string& folder, const std::vector<std::string>& patterns);

/// The images of a camera that has a folder of its own, or its video; files of other kinds do not count.
///
/// @throws Error(kIo) when there are none; Error(kBadInput) as image_files
std::vector<ImageFile> images_in_folder(int camera, const std::string& folder);

/// @param cameras  their names
/// @throws Error(kBadInput) naming an image that two cameras have
void refuse_shared_images(const std::vector<ImageFile>& files, const std::vector<std::string>& cameras);

/// Warns of two images, named as a pair, whose numbers say that they are of different moments.
void warn_of_other_moment(const std::string& a, const std::string& b);

/// An 8- or 16-bit grey image; empty, with the reason set, when the file cannot be read, is truncated or no image.
cv::Mat read_gray(const std::string& path, std::string& reason);

/// The same of a file that has to be one.
///
/// @throws Error(kIo) with the reason
cv::Mat read_gray(const std::string& path);

inline constexpr const char* kNoVideo = "not a video that can be decoded";  ///< why a video has no first frame

/// Whether a path ends as those of images, or of videos, do.
bool is_image(const std::string& path);
bool is_video(const std::string& path);

/// Whether a file may be an image by what it holds, however it is called.
bool may_be_image(const std::string& path);

/// Images in 8 bits. Those of more are scaled alike, by the least number of bits, of 10, 12 and 16, that holds the
/// brightest pixel of all so far: a darker image stays darker.
class EightBits {
 public:
  void take(std::initializer_list<cv::Mat*> images);

 private:
  double brightest_ = 0.0;
};

/// Calls use(gray, frame) for the image, or for every frame of the video in order, with its frame name.
///
/// @return  the reason when the file cannot be read, else empty
std::string for_each_frame(const ImageFile& file,
                           const std::function<void(const cv::Mat& gray, const std::string& frame)>& use);

/// The same for many files on several threads; `use` is called from all of them. Memory is bounded by the threads.
///
/// @param what  of the progress bar
/// @param done  called for each file that could be read, behind its last frame; one call at a time
/// @return      aligned with files: why a file could not be read, or empty
std::vector<std::string> for_each_frame(
    const std::vector<ImageFile>& files, int threads, const std::string& what,
    const std::function<void(std::size_t file, const cv::Mat& gray, const std::string& frame)>& use,
    const std::function<void(std::size_t file)>& done = {});

}  // namespace raybundle::apps
