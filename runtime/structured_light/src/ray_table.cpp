// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/structured_light/ray_table.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

constexpr double kWanted_rad = 2e-6, kTolerable_rad = 1e-4;
constexpr double kSteps_px[] = {32.0, 16.0, 8.0, 4.0};
constexpr double kMargin = 2.0;  // of the stated bound over the largest error at the places that are tried

// Weights of four nodes at -1, 0, 1, 2 for a place t in [-1, 2], and their derivatives. Source: Lagrange's formula.
struct Cubic {
  int first = 0;  // of the four nodes
  double weight[4];
  double slope[4];  // for each pixel

  Cubic(double pixel, double step_px, int nodes) {
    first = std::clamp(static_cast<int>(pixel / step_px) - 1, 0, nodes - 4);
    const double t = pixel / step_px - first - 1.0;
    const double a = t + 1.0, b = t - 1.0, c = t - 2.0;
    weight[0] = -t * b * c / 6.0;
    weight[1] = a * b * c / 2.0;
    weight[2] = -a * t * c / 2.0;
    weight[3] = a * t * b / 6.0;
    slope[0] = -(b * c + t * c + t * b) / (6.0 * step_px);
    slope[1] = (b * c + a * c + a * b) / (2.0 * step_px);
    slope[2] = -(t * c + a * c + a * t) / (2.0 * step_px);
    slope[3] = (t * b + a * b + a * t) / (6.0 * step_px);
  }
};

RayTable table_of_step(const Camera& camera, double step_px) {
  RayTable table{camera.size, step_px, nodes_over(camera.size.width, step_px), nodes_over(camera.size.height, step_px),
                 {},          0.0};
  const Eigen::Vector3d none = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  for (int row = 0; row < table.rows; ++row) {
    for (int column = 0; column < table.columns; ++column) {
      const Eigen::Vector3d ray = ray_from_pixel(camera, {column * step_px, row * step_px}).value_or(none);
      table.nodes.insert(table.nodes.end(), ray.data(), ray.data() + 3);
    }
  }
  return table;
}

// Largest angle between rays of the table and of the camera, at quarters of the steps.
double largest_error_rad(const RayTable& table, const Camera& camera) {
  double largest = 0.0;
  const double part = table.step_px / 4.0;
  for (double v = 0.0; v <= camera.size.height - 1; v += part) {
    for (double u = 0.0; u <= camera.size.width - 1; u += part) {
      const Eigen::Vector3d ray = table.at({u, v}).direction;
      if (std::isnan(ray.x())) continue;
      const auto exact = ray_from_pixel(camera, {u, v});
      largest = std::max(largest, exact ? (ray - *exact).norm() : M_PI);
    }
  }
  return largest;
}

}  // namespace

int nodes_over(int pixels, double step_px) {
  return std::max(4, static_cast<int>(std::ceil((pixels - 1) / step_px)) + 1);
}

RayTable::Ray RayTable::at(const Eigen::Vector2d& pixel) const {
  const Cubic u(pixel.x(), step_px, columns), v(pixel.y(), step_px, rows);
  Eigen::Vector3d value = Eigen::Vector3d::Zero(), by_u = value, by_v = value;
  for (int i = 0; i < 4; ++i) {
    const double* node = nodes.data() + 3 * (static_cast<std::ptrdiff_t>(v.first + i) * columns + u.first);
    Eigen::Vector3d along = Eigen::Vector3d::Zero(), slope = along;
    for (int k = 0; k < 4; ++k, node += 3) {
      const Eigen::Map<const Eigen::Vector3d> ray(node);
      along += u.weight[k] * ray;
      slope += u.slope[k] * ray;
    }
    value += v.weight[i] * along;
    by_u += v.weight[i] * slope;
    by_v += v.slope[i] * along;
  }
  const double length = value.norm();
  Ray ray{value / length, {}};
  ray.per_px.col(0) = (by_u - ray.direction * ray.direction.dot(by_u)) / length;
  ray.per_px.col(1) = (by_v - ray.direction * ray.direction.dot(by_v)) / length;
  return ray;
}

RayTable ray_table(const Camera& camera) {
  RayTable table;
  for (const double step_px : kSteps_px) {
    table = table_of_step(camera, step_px);
    table.error_rad = kMargin * largest_error_rad(table, camera);
    if (table.error_rad <= kWanted_rad) return table;
  }
  if (table.error_rad > kTolerable_rad) {
    throw Error(ErrorKind::kBadInput,
                "the lens bends too strongly for a table of rays; look at its parameters with "
                "`raybundle project`, and calibrate it with views up to the rim");
  }
  return table;
}

}  // namespace raybundle
