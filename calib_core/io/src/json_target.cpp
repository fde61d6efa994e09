// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "json_target.hpp"

#include <algorithm>
#include <limits>

namespace raybundle {
namespace {

constexpr int kMaxId = std::numeric_limits<int>::max();

std::vector<TargetPoint> points_from(const JsonNode& nodes) {
  std::vector<TargetPoint> points;
  for (std::size_t i = 0; i < nodes.array_size(); ++i) {
    const JsonNode node = nodes[i];
    node.expect_array_size(4);
    const TargetPoint point{node[0].whole_number(0, kMaxId), {node[1].number(), node[2].number(), node[3].number()}};
    if (!points.empty() && points.back().id >= point.id) {
      node.fail("has id " + std::to_string(point.id) + " after " + std::to_string(points.back().id) +
                "; sort the points by id, each id once");
    }
    points.push_back(point);
  }
  return points;
}

TargetSymmetry symmetry_from(const JsonNode& node, const std::vector<TargetPoint>& points) {
  node.expect_array_size(points.size());
  TargetSymmetry symmetry;
  for (std::size_t i = 0; i < points.size(); ++i) symmetry.ids.push_back(node[i].whole_number(0, kMaxId));
  std::vector<int> sorted = symmetry.ids;
  std::ranges::sort(sorted);
  if (!std::ranges::equal(sorted, points, {}, {}, &TargetPoint::id)) {
    node.fail("is not a reordering of the ids of the points; correct it");
  }
  return symmetry;
}

}  // namespace

Target target_from(const JsonNode& node) {
  Target target{node.at("name").name(), points_from(node.at("points")), {}};
  if (const auto symmetries = node.find("symmetries")) {
    for (std::size_t i = 0; i < symmetries->array_size(); ++i) {
      target.symmetries.push_back(symmetry_from((*symmetries)[i], target.points));
    }
  }
  return target;
}

std::vector<CalibratedTarget> calibrated_targets_from(const JsonNode& nodes) {
  std::vector<CalibratedTarget> targets;
  for (std::size_t i = 0; i < nodes.array_size(); ++i) {
    const JsonNode node = nodes[i];
    const JsonNode shape = node.at("shape");
    targets.push_back({target_from(node),
                       {shape.at("bend_x_m").number(), shape.at("bend_y_m").number(), shape.at("twist_m").number()}});
  }
  return targets;
}

}  // namespace raybundle
