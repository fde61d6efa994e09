// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "tiff_orientation.hpp"

#include <cstdint>
#include <opencv2/core.hpp>

namespace raybundle::apps {
namespace {

constexpr std::uint32_t kUpright = 1;

// Numbers of a TIFF, whose first bytes say in which order it has theirs; 0 behind the end.
struct Tiff {
  std::string_view bytes;
  bool big_endian;

  std::uint32_t number(std::size_t at, std::size_t size) const {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size && at + size <= bytes.size(); ++i) {
      const std::size_t from = big_endian ? at + i : at + size - 1 - i;
      value = value << 8 | static_cast<std::uint8_t>(bytes[from]);
    }
    return value;
  }
};

// Source: TIFF revision 6.0, sections 2 and 8, tag 274.
std::uint32_t orientation_of(std::string_view bytes) {
  constexpr std::uint32_t kOrientation = 274;
  const bool little = bytes.starts_with(std::string_view("II*\0", 4));
  const bool big = bytes.starts_with(std::string_view("MM\0*", 4));
  if (!little && !big) return kUpright;
  const Tiff tiff{bytes, big};
  const std::size_t directory = tiff.number(4, 4), entries = tiff.number(directory, 2);
  for (std::size_t i = 0; i < entries; ++i) {
    const std::size_t entry = directory + 2 + 12 * i;
    if (tiff.number(entry, 2) == kOrientation) return tiff.number(entry + 8, 2);
  }
  return kUpright;
}

}  // namespace

cv::Mat as_stored(std::string_view bytes, const cv::Mat& decoded) {
  cv::Mat stored = decoded;
  switch (orientation_of(bytes)) {
    case 2:
      cv::flip(decoded, stored, 1);
      break;
    case 3:
      cv::rotate(decoded, stored, cv::ROTATE_180);
      break;
    case 4:
      cv::flip(decoded, stored, 0);
      break;
    case 5:
      cv::transpose(decoded, stored);
      break;
    case 6:
      cv::rotate(decoded, stored, cv::ROTATE_90_COUNTERCLOCKWISE);
      break;
    case 7:
      cv::transpose(decoded, stored);
      cv::rotate(stored, stored, cv::ROTATE_180);
      break;
    case 8:
      cv::rotate(decoded, stored, cv::ROTATE_90_CLOCKWISE);
      break;
    default:
      break;
  }
  return stored;
}

}  // namespace raybundle::apps
