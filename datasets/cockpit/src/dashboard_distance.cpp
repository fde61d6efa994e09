// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "dashboard_distance.hpp"

#include <algorithm>
#include <limits>

namespace raybundle {
namespace {

using Polygon = std::vector<Eigen::Vector3f>;

// The part of a polygon where value(place) >= 0, value being linear. Source: Sutherland and Hodgman 1974.
template <typename Value>
Polygon clipped(const Polygon& polygon, const Value& value) {
  Polygon kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector3f& a = polygon[i];
    const Eigen::Vector3f& b = polygon[(i + 1) % polygon.size()];
    const float at_a = value(a), at_b = value(b);
    if (at_a >= 0) kept.push_back(a);
    if ((at_a >= 0) != (at_b >= 0)) kept.push_back(a + at_a / (at_a - at_b) * (b - a));
  }
  return kept;
}

}  // namespace

std::optional<Eigen::Vector3d> nearest_to_dashboard(const std::vector<CabinMesh>& meshes, const CabinLayout& layout) {
  const auto floor = static_cast<float>(layout.zone_floor_m), half = static_cast<float>(layout.zone_half_width_m);
  std::optional<Eigen::Vector3f> nearest;
  for (const CabinMesh& mesh : meshes) {
    for (const Eigen::Vector3i& t : mesh.triangles) {
      Polygon part{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
      if (nearest && std::max({part[0].x(), part[1].x(), part[2].x()}) <= nearest->x()) continue;
      part = clipped(part, [&](const Eigen::Vector3f& place) { return place.z() - floor; });
      part = clipped(part, [&](const Eigen::Vector3f& place) { return half - place.y(); });
      part = clipped(part, [&](const Eigen::Vector3f& place) { return half + place.y(); });
      for (const Eigen::Vector3f& place : part) {
        if (!nearest || place.x() > nearest->x()) nearest = place;
      }
    }
  }
  return nearest ? std::optional<Eigen::Vector3d>(nearest->cast<double>()) : std::nullopt;
}

double dashboard_distance(const std::vector<CabinMesh>& meshes, const CabinLayout& layout) {
  const std::optional<Eigen::Vector3d> nearest = nearest_to_dashboard(meshes, layout);
  return nearest ? std::max(0.0, layout.dashboard_x_m - nearest->x()) : std::numeric_limits<double>::infinity();
}

}  // namespace raybundle
