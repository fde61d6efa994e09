// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "head_surface.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "head_fit.hpp"

namespace raybundle {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kOutline2 = 0.81;  // of the ball's radius, squared: farther out is the matcher's smear
constexpr double kNear_m = 0.012;   // and two sigmas: what is farther off is no part of this surface

// A quadric over the plane across the line of sight, fitted to how far points are off the unit ball.
struct Quadric {
  Matrix6 information = Matrix6::Zero();
  Vector6 sums = Vector6::Zero();
  int points = 0;

  void add(double u, double v, double off) {
    Vector6 row;
    row << 1.0, u, v, u * u, u * v, v * v;
    information += row * row.transpose();
    sums += off * row;
    ++points;
  }

  // Twice what is greatest of a u² + b u v + c v² on the unit circle, by its size: a plane is off by half of u² + v².
  double bend() const {
    const Vector6 shape = information.ldlt().solve(sums);
    const double a = shape[3], b = shape[4], c = shape[5];
    return std::abs(a + c) + std::hypot(a - c, b);
  }
};

}  // namespace

HeadSurface surface_of(const CappedScan& capped, const Head& head, const HeadOptions& options) {
  const Eigen::Vector3d& eye_in_vehicle = capped.scan().viewpoint_in_vehicle;
  const Eigen::Vector3d centre = head.centre - head.vehicle_from_head * options.centre_from_hair_m;
  const auto in_ball = [&](const Eigen::Vector3d& x) -> Eigen::Vector3d {
    return (head.vehicle_from_head.transpose() * (x - centre)).cwiseQuotient(head.semi_axes_m);
  };
  const Eigen::Vector3d eye = in_ball(eye_in_vehicle), right = eye.unitOrthogonal(), up = eye.normalized().cross(right);
  Quadric quadric;
  int through_it = 0, behind = 0;
  for (const ScenePoint& point : capped.scan().points) {
    const Eigen::Vector3d through = in_ball(point.x_in_vehicle) - eye;
    const double range = through.norm(), nearest = -eye.dot(through) / range;
    const double outline2 = eye.squaredNorm() - nearest * nearest;
    if (nearest < 0.0 || outline2 > kOutline2) continue;
    const double facing = std::sqrt(1.0 - outline2), to_front = nearest - facing;
    const Eigen::Vector3d front = eye + to_front / range * through;
    const double off = facing * (range - to_front), off_m = off / front.cwiseQuotient(head.semi_axes_m).norm();
    if (front.z() < kChin) continue;
    ++through_it;
    behind += (1.0 - nearest / range) * (point.x_in_vehicle - eye_in_vehicle).norm() > kBehind_m;
    if (std::abs(off_m) > kNear_m + 2.0 * capped.sigma_m(point)) continue;
    quadric.add(front.dot(right), front.dot(up), off);
  }
  const bool told = quadric.points >= options.least_points / 2;
  return {told ? quadric.bend() : std::numeric_limits<double>::infinity(), behind / std::max(1.0, 1.0 * through_it)};
}

}  // namespace raybundle
