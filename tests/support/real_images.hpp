// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "real_data.hpp"

namespace raybundle::testing {

/// Image files of a folder of the real data whose names begin with `prefix`, sorted; empty when it is not there.
inline std::vector<std::filesystem::path> real_images(const std::string& folder, const std::string& prefix = "") {
  std::vector<std::filesystem::path> files;
  const std::filesystem::path place = real_data(folder);
  if (!std::filesystem::is_directory(place)) return files;
  for (const auto& entry : std::filesystem::directory_iterator(place)) {
    const std::string extension = entry.path().extension();
    const bool image = extension == ".jpg" || extension == ".png" || extension == ".pgm";
    if (image && entry.path().filename().string().starts_with(prefix)) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

inline cv::Mat grey_image(const std::filesystem::path& file) { return cv::imread(file.string(), cv::IMREAD_GRAYSCALE); }

}  // namespace raybundle::testing

/// Skips a test, saying so, when there are no such images.
#define RAYBUNDLE_NEEDS_IMAGES(files, folder)                                                \
  if ((files).empty()) {                                                                     \
    GTEST_SKIP() << "no real images in " << (raybundle::testing::real_data(folder)).string() \
                 << ": set RAYBUNDLE_DATA to the folder that holds them to run this test";   \
  }
