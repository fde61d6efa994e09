// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/scene/target.hpp"

#include <algorithm>

#include "raybundle/scene/board_surface.hpp"

namespace raybundle {

const TargetPoint* Target::find_among_others(int id) const {
  const auto found = std::ranges::lower_bound(points, id, {}, &TargetPoint::id);
  return found != points.end() && found->id == id ? &*found : nullptr;
}

bool Target::flat() const {
  return std::ranges::all_of(points, [](const TargetPoint& point) { return point.x_in_target.z() == 0.0; });
}

std::vector<Eigen::Vector3d> shape_basis(const Target& target) {
  std::vector<Eigen::Vector3d> basis(target.points.size(), Eigen::Vector3d::Zero());
  if (target.points.empty() || !target.flat()) return basis;
  const BoardSurface surface(target);
  for (std::size_t i = 0; i < basis.size(); ++i) {
    const Eigen::Vector3d& x = target.points[i].x_in_target;
    basis[i] = surface.basis(x.x(), x.y());
  }
  return basis;
}

std::vector<Eigen::Vector3d> points_on_surface(const Target& target, const BoardShape& shape) {
  const std::vector<Eigen::Vector3d> basis = shape_basis(target);
  const Eigen::Vector3d sags = shape.sags();
  std::vector<Eigen::Vector3d> points;
  points.reserve(basis.size());
  for (std::size_t i = 0; i < basis.size(); ++i) {
    points.push_back(target.points[i].x_in_target + Eigen::Vector3d(0, 0, basis[i].dot(sags)));
  }
  return points;
}

}  // namespace raybundle
