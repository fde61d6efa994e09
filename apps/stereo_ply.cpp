// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "stereo_ply.hpp"

#include <fmt/format.h>

#include <array>
#include <cstring>
#include <string_view>

#include "raybundle/scene/number.hpp"

namespace raybundle::apps {
namespace {

constexpr std::size_t kRecord = sizeof(StereoPoint) + 1;  // and the pixel's grey
constexpr const char *kVertices = "\nelement vertex ", *kEnd = "\nend_header\n";

}  // namespace

std::string stereo_ply(const StereoFrame& frame) {
  std::string records;
  for (int v = 0; v < frame.points.height; ++v) {
    for (int u = 0; u < frame.points.width; ++u) {
      const StereoPoint& point = frame.points.at(u, v);
      if (point.sigma_m == 0) continue;
      std::array<char, kRecord> record{};
      std::memcpy(record.data(), &point, sizeof point);
      record.back() = static_cast<char>(frame.left.at(u, v));
      records.append(record.data(), record.size());
    }
  }
  return fmt::format(
             "ply\nformat binary_little_endian 1.0\n"
             "comment metres in the rectified frame: x along the baseline, y down, z forward, from the left camera"
             "{}{}\nproperty float x\nproperty float y\nproperty float z\nproperty float sigma\nproperty uchar grey{}",
             kVertices, records.size() / kRecord, kEnd) +
         records;
}

std::optional<std::vector<StereoPoint>> points_of_stereo_ply(const std::string& bytes) {
  const std::size_t header = bytes.find(kEnd), vertices = bytes.find(kVertices);
  if (header == std::string::npos || vertices > header) return std::nullopt;
  const std::size_t digits = vertices + std::strlen(kVertices), begin = header + std::strlen(kEnd);
  const int count =
      number_from<int>(std::string_view(bytes).substr(digits, bytes.find('\n', digits) - digits)).value_or(-1);
  if (count < 0 || bytes.size() != begin + static_cast<std::size_t>(count) * kRecord) {
    return std::nullopt;
  }
  std::vector<StereoPoint> points(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::memcpy(&points[i], bytes.data() + begin + i * kRecord, sizeof points[i]);
  }
  return points;
}

}  // namespace raybundle::apps
