// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/structured_light/laser_points.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace raybundle {

LaserPoint laser_point(const TableBeam& beam, const BeamGeometry& geometry, const RayTable::Ray& ray,
                       const Eigen::Matrix2d& covariance_px2, double log_wavelength_variance) {
  const BeamPoint at = beam_point(geometry, ray.direction);
  const Eigen::Matrix3d in_plane =
      Eigen::Matrix3d::Identity() - geometry.normal * geometry.normal.transpose();  // projects onto the epipolar plane
  const double towards = ray.direction.dot(geometry.across);
  const double range = geometry.distance_m / towards;
  // x = range(ray) in_plane ray, range = distance / (ray · across)
  const Eigen::Matrix3d by_ray = range * in_plane - at.x * geometry.across.transpose() / towards;
  const Eigen::Matrix<double, 3, 2> by_px = by_ray * ray.per_px;
  // A beam that moves by d takes the point along: with the plane across it, and in the plane along the ray.
  const Eigen::Matrix3d by_shift = geometry.normal * geometry.normal.transpose() +
                                   at.ray * geometry.across.transpose() / at.ray.dot(geometry.across);
  const Eigen::Matrix<double, 3, 2> basis = across(beam.line.direction);
  Eigen::Matrix<double, 3, 4> by_motion;
  by_motion << by_shift * basis, at.along_m * (by_shift * basis);
  const Eigen::Matrix4d of_motion =
      beam.covariance + log_wavelength_variance * beam.per_wavelength * beam.per_wavelength.transpose();
  LaserPoint point;
  point.x_in_camera = at.x;
  point.covariance = by_px * covariance_px2 * by_px.transpose() + by_motion * of_motion * by_motion.transpose();
  return point;
}

void mesh(const BeamLattice& lattice, std::span<const LaserPoint> points, std::span<const int> point_of_beam,
          double most_slant, std::vector<Triangle>& triangles) {
  triangles.clear();
  const auto point_at = [&](int row, int column) {
    const int beam = lattice.at(row, column);
    return beam < 0 ? -1 : point_of_beam[beam];
  };
  // A side is compared with the arc between its rays at the nearer end.
  const auto spans = [&](int i, int k) {
    const Eigen::Vector3d &a = points[i].x_in_camera, &b = points[k].x_in_camera;
    const double near = std::min(a.norm(), b.norm());
    return (a - b).norm() <= most_slant * near * (a.normalized() - b.normalized()).norm();
  };
  const auto add = [&](int a, int b, int c) {
    if (a < 0 || b < 0 || c < 0 || !spans(a, b) || !spans(b, c) || !spans(c, a)) return;
    const Eigen::Vector3d &x = points[a].x_in_camera, &y = points[b].x_in_camera, &z = points[c].x_in_camera;
    if ((y - x).cross(z - x).dot(x) > 0.0) std::swap(b, c);  // the camera is at the origin, before the surface
    triangles.push_back({a, b, c});
  };
  for (int row = 0; row + 1 < lattice.rows; ++row) {
    for (int column = 0; column + 1 < lattice.columns; ++column) {
      const int a = point_at(row, column), b = point_at(row, column + 1);
      const int c = point_at(row + 1, column + 1), d = point_at(row + 1, column);
      const bool both = a >= 0 && b >= 0 && c >= 0 && d >= 0;
      const bool ac = !both || (points[a].x_in_camera - points[c].x_in_camera).norm() <=
                                   (points[b].x_in_camera - points[d].x_in_camera).norm();  // the shorter diagonal
      if (both && ac) {
        add(a, b, c);
        add(a, c, d);
      } else if (both) {
        add(a, b, d);
        add(b, c, d);
      } else {
        add(a, b, c);
        add(a, c, d);
        add(a, b, d);
        add(b, c, d);
      }
    }
  }
}

}  // namespace raybundle
