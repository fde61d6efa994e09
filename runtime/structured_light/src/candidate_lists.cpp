// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "candidate_lists.hpp"

#include <algorithm>
#include <cmath>

namespace raybundle {
namespace {

std::optional<CurvePoint> point_at(const Camera& camera, const Line3& line, double depth_m) {
  if (std::abs(line.direction.z()) < 1e-6) return std::nullopt;
  const double along = (depth_m - line.point.z()) / line.direction.z();
  const auto pixel = pixel_from_ray(camera, line.at(along));
  return pixel && camera.size.contains(*pixel) ? std::optional(CurvePoint{*pixel, depth_m}) : std::nullopt;
}

}  // namespace

std::vector<CurvePoint> beam_curve(const Camera& camera, const Line3& line, const SensorRange& range, double step_px) {
  // Equal steps of inverse depth are nearly equal steps in the image; as many as the longest of a few coarse ones asks.
  constexpr int kCoarse = 16;
  const double from = 1.0 / range.farthest_m, to = 1.0 / range.nearest_m;
  const auto at = [&](int i, int count) { return point_at(camera, line, 1.0 / (from + (to - from) * i / count)); };
  double longest = step_px;
  for (int i = 0; i < kCoarse; ++i) {
    const auto a = at(i, kCoarse), b = at(i + 1, kCoarse);
    if (a && b) longest = std::max(longest, (b->pixel - a->pixel).norm());
  }
  const int count = kCoarse * 2 * static_cast<int>(std::ceil(longest / step_px));
  std::vector<CurvePoint> curve;
  for (int i = 0; i <= count; ++i) {
    if (const auto point = at(i, count)) curve.push_back(*point);
  }
  return curve;
}

std::span<const std::uint16_t> CandidateLists::at(const Eigen::Vector2d& pixel) const {
  const int u = static_cast<int>(pixel.x() + 0.5) / cell_px, v = static_cast<int>(pixel.y() + 0.5) / cell_px;
  const std::size_t cell = static_cast<std::size_t>(v) * columns + u;
  return {beams.data() + first[cell], first[cell + 1] - first[cell]};
}

CandidateLists candidate_lists(const ImageSize& size, const std::vector<std::vector<CurvePoint>>& curves,
                               double margin_px) {
  CandidateLists lists;
  const int cell = lists.cell_px;
  lists.columns = (size.width + cell - 1) / cell;
  lists.rows = (size.height + cell - 1) / cell;
  std::vector<std::vector<std::uint16_t>> in_cell(static_cast<std::size_t>(lists.columns) * lists.rows);
  const auto cell_of = [cell](double px, int count) {
    return std::clamp(static_cast<int>(std::floor((px + 0.5) / cell)), 0, count - 1);
  };
  for (std::size_t beam = 0; beam < curves.size(); ++beam) {
    for (const CurvePoint& point : curves[beam]) {
      const int right = cell_of(point.pixel.x() + margin_px, lists.columns);
      const int low = cell_of(point.pixel.y() + margin_px, lists.rows);
      for (int v = cell_of(point.pixel.y() - margin_px, lists.rows); v <= low; ++v) {
        for (int u = cell_of(point.pixel.x() - margin_px, lists.columns); u <= right; ++u) {
          auto& list = in_cell[static_cast<std::size_t>(v) * lists.columns + u];
          if (list.empty() || list.back() != beam) list.push_back(static_cast<std::uint16_t>(beam));
        }
      }
    }
  }
  lists.first.push_back(0);
  for (const auto& list : in_cell) {
    lists.beams.insert(lists.beams.end(), list.begin(), list.end());
    lists.first.push_back(static_cast<std::uint32_t>(lists.beams.size()));
  }
  return lists;
}

}  // namespace raybundle
