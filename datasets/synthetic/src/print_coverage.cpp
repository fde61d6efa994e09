// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "print_coverage.hpp"

#include <algorithm>
#include <cmath>

#include "view_geometry.hpp"

namespace raybundle {
namespace {

constexpr int kCells = 96;  // of the grid, each way
constexpr int kMostCorners = 8;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

struct Polygon {
  std::array<Eigen::Vector2d, kMostCorners> corners;
  int count = 0;

  void add(const Eigen::Vector2d& corner) {
    if (count < kMostCorners) corners[count++] = corner;
  }
  double area() const {
    double twice = 0;
    for (int i = 1; i + 1 < count; ++i) twice += cross(corners[i] - corners[0], corners[i + 1] - corners[0]);
    return 0.5 * std::abs(twice);
  }
};

// The part where sign * (coordinate - limit) <= 0. Source: Sutherland and Hodgman 1974.
Polygon clipped(const Polygon& polygon, int axis, double sign, double limit) {
  Polygon kept;
  for (int i = 0; i < polygon.count; ++i) {
    const Eigen::Vector2d& from = polygon.corners[i];
    const Eigen::Vector2d& to = polygon.corners[i + 1 == polygon.count ? 0 : i + 1];
    const double a = sign * (from[axis] - limit), b = sign * (to[axis] - limit);
    if (a <= 0) kept.add(from);
    if ((a < 0 && b > 0) || (a > 0 && b < 0)) kept.add(from + a / (a - b) * (to - from));
  }
  return kept;
}

// Signed area of a disc about the origin within the triangle (origin, a, b).
double sector_area(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double radius) {
  const auto pie = [radius](const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    return 0.5 * radius * radius * std::atan2(cross(from, to), from.dot(to));
  };
  const Eigen::Vector2d along = b - a;
  const double aa = along.squaredNorm(), half_b = a.dot(along), c = a.squaredNorm() - radius * radius;
  const double root = half_b * half_b - aa * c;
  if (aa == 0) return 0;
  if (root <= 0) return pie(a, b);
  const double s = std::sqrt(root), enter = (-half_b - s) / aa, leave = (-half_b + s) / aa;
  if (leave <= 0 || enter >= 1) return pie(a, b);
  const Eigen::Vector2d in = a + std::max(0.0, enter) * along, out = a + std::min(1.0, leave) * along;
  double area = 0.5 * cross(in, out);
  if (enter > 0) area += pie(a, in);
  if (leave < 1) area += pie(out, b);
  return area;
}

bool disjoint(const Eigen::Vector2d& low, const Eigen::Vector2d& high, const BoardPrint::Box& box) {
  return low.x() >= box.high.x() || low.y() >= box.high.y() || high.x() <= box.low.x() || high.y() <= box.low.y();
}

BoardPrint::Box around(const BoardPrint::Disc& disc) {
  return {disc.centre.array() - disc.radius, disc.centre.array() + disc.radius};
}

}  // namespace

double Quad::area() const { return 0.5 * std::abs(cross(corners[2] - corners[0], corners[3] - corners[1])); }

double area_in_box(const Quad& quad, const BoardPrint::Box& box) {
  const Eigen::Vector2d low = quad.low(), high = quad.high();
  if (disjoint(low, high, box)) return 0;
  Polygon polygon;
  for (const Eigen::Vector2d& corner : quad.corners) polygon.add(corner);
  for (int axis = 0; axis < 2; ++axis) {
    if (low[axis] < box.low[axis]) polygon = clipped(polygon, axis, -1, box.low[axis]);
    if (high[axis] > box.high[axis]) polygon = clipped(polygon, axis, 1, box.high[axis]);
  }
  return polygon.area();
}

double area_in_disc(const Quad& quad, const BoardPrint::Disc& disc) {
  double area = 0;
  for (int i = 0; i < 4; ++i) {
    area += sector_area(quad.corners[i] - disc.centre, quad.corners[(i + 1) % 4] - disc.centre, disc.radius);
  }
  return std::abs(area);
}

PrintCoverage::PrintCoverage(const BoardPrint& print)
    : print_(print), cell_size_((print.sheet.high - print.sheet.low) / kCells), cells_(kCells * kCells) {
  int shape = 0;
  for (const BoardPrint::Box& box : print_.boxes) insert(shape++, box.low, box.high);
  for (const BoardPrint::Disc& disc : print_.discs) insert(shape++, around(disc).low, around(disc).high);
}

Eigen::Array2i PrintCoverage::cell_of(const Eigen::Vector2d& place) const {
  const Eigen::Array2d cell = (place - print_.sheet.low).array() / cell_size_.array();
  return cell.max(0.0).min(kCells - 1.0).cast<int>();
}

void PrintCoverage::insert(int shape, const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  const Eigen::Array2i first = cell_of(low), last = cell_of(high);
  for (int j = first.y(); j <= last.y(); ++j) {
    for (int i = first.x(); i <= last.x(); ++i) cells_[j * kCells + i].push_back(shape);
  }
}

template <typename Visit>
void PrintCoverage::for_each_near(const Eigen::Vector2d& low, const Eigen::Vector2d& high, Visit&& visit) const {
  const Eigen::Array2i first = cell_of(low), last = cell_of(high);
  const auto visited_before = [&](int shape, int i, int j) {
    for (int y = first.y(); y <= j; ++y) {
      for (int x = first.x(); x <= (y == j ? i - 1 : last.x()); ++x) {
        if (std::ranges::find(cells_[y * kCells + x], shape) != cells_[y * kCells + x].end()) return true;
      }
    }
    return false;
  };
  for (int j = first.y(); j <= last.y(); ++j) {
    for (int i = first.x(); i <= last.x(); ++i) {
      for (const int shape : cells_[j * kCells + i]) {
        if (!visited_before(shape, i, j) && !visit(shape)) return;
      }
    }
  }
}

double PrintCoverage::ink_area(const Quad& quad) const {
  const int boxes = static_cast<int>(print_.boxes.size());
  double area = 0;
  for_each_near(quad.low(), quad.high(), [&](int shape) {
    area += shape < boxes ? area_in_box(quad, print_.boxes[shape]) : area_in_disc(quad, print_.discs[shape - boxes]);
    return true;
  });
  return print_.ground ? std::max(0.0, area_in_box(quad, *print_.ground) - area) : area;
}

int PrintCoverage::uniform(const Quad& quad) const {
  const Eigen::Vector2d low = quad.low(), high = quad.high();
  const int boxes = static_cast<int>(print_.boxes.size());
  int in_shape = 0;
  for_each_near(low, high, [&](int shape) {
    const BoardPrint::Box box = shape < boxes ? print_.boxes[shape] : around(print_.discs[shape - boxes]);
    if (disjoint(low, high, box)) return true;
    const bool whole = shape < boxes && contains(box, low) && contains(box, high);
    in_shape = whole ? 1 : -1;
    return false;
  });
  if (!print_.ground || in_shape < 0) return in_shape;
  if (disjoint(low, high, *print_.ground)) return 0;
  return contains(*print_.ground, low) && contains(*print_.ground, high) ? 1 - in_shape : -1;
}

}  // namespace raybundle
