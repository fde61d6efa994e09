// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/scene/board_surface.hpp"

#include <cmath>

#include "raybundle/geometry/error.hpp"

namespace raybundle {

BoardSurface::BoardSurface(const Target& target) {
  if (!target.flat() || target.points.empty()) {
    throw Error(ErrorKind::kBadInput, "is not a flat board, so it has no surface between its points",
                "target " + target.name);
  }
  Eigen::Array2d low = target.points.front().x_in_target.head<2>();
  Eigen::Array2d high = low;
  for (const TargetPoint& point : target.points) {
    low = low.min(point.x_in_target.head<2>().array());
    high = high.max(point.x_in_target.head<2>().array());
  }
  centre_ = 0.5 * (low + high);
  half_ = (0.5 * (high - low)).max(1e-12);  // a single row of points has no extent across
}

Eigen::Vector3d BoardSurface::basis(double x, double y) const {
  const Eigen::Array2d p = (Eigen::Array2d(x, y) - centre_) / half_;
  return {1 - p.x() * p.x(), 1 - p.y() * p.y(), p.x() * p.y()};
}

double BoardSurface::height(double x, double y, const BoardShape& shape) const { return basis(x, y).dot(shape.sags()); }

Eigen::Vector3d BoardSurface::normal(double x, double y, const BoardShape& shape) const {
  const Eigen::Array2d p = (Eigen::Array2d(x, y) - centre_) / half_;
  return {(2 * shape.bend_x_m * p.x() - shape.twist_m * p.y()) / half_.x(),
          (2 * shape.bend_y_m * p.y() - shape.twist_m * p.x()) / half_.y(), 1.0};
}

std::optional<Eigen::Vector3d> BoardSurface::crossing(const Line3& line_in_target, const BoardShape& shape) const {
  constexpr int kMaxSteps = 8;
  const Eigen::Vector3d& direction = line_in_target.direction;
  if (std::abs(direction.z()) < 1e-9) return std::nullopt;
  Eigen::Vector3d x = line_in_target.at(-line_in_target.point.z() / direction.z());
  for (int step = 0; step < kMaxSteps; ++step) {
    const double above = x.z() - height(x.x(), x.y(), shape);
    const double slope = normal(x.x(), x.y(), shape).dot(direction);
    if (std::abs(slope) < 1e-9) return std::nullopt;
    x -= above / slope * direction;
    if (std::abs(above) < 1e-15) break;
  }
  return x.allFinite() ? std::optional(x) : std::nullopt;
}

bool BoardSurface::covers(const Eigen::Vector3d& x_in_target, double margin_m) const {
  return ((x_in_target.head<2>().array() - centre_).abs() <= half_ + margin_m).all();
}

}  // namespace raybundle
