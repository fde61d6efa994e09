// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <sys/mman.h>
#include <unistd.h>

#include <opencv2/core/utility.hpp>
#include <string>

#include "fuzz_reader.hpp"
#include "image_files.hpp"
#include "media/media.hpp"

// A file in memory is given to the reader of images by its name.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raybundle;
  static const int file = ::memfd_create("image", 0);
  apps::media();  // without which most formats would be refused unread
  if (::ftruncate(file, 0) != 0 || ::pwrite(file, data, size, 0) != static_cast<ssize_t>(size)) return 0;
  return fuzz::only_errors(data, size, [](std::string_view) {
    std::string reason;
    const cv::Mat gray = apps::read_gray("/proc/self/fd/" + std::to_string(file), reason);
    fuzz::require(gray.empty() != reason.empty(), "an image or a reason");
    fuzz::require(gray.empty() || gray.type() == CV_8UC1 || gray.type() == CV_16UC1, "grey");
  });
}
