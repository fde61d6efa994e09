// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "cabin_scene.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace raybundle::testing {
namespace {

Eigen::Matrix3d turned(const Eigen::Vector3d& turn) {
  const double angle = turn.norm();
  if (angle == 0.0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
}

}  // namespace

CabinScene::CabinScene(std::uint64_t seed) {
  Random random(seed);
  const auto about = [&](double middle, double spread) { return middle + spread * random.uniform(-1.0, 1.0); };
  const auto vector = [&](double x, double y, double z, double spread) {
    return Eigen::Vector3d(about(x, spread), about(y, spread), about(z, spread));
  };
  // The sensor looks down and back: image left and right are door and console, up is the back of the car.
  planes_.push_back({Eigen::Vector3d(about(0, 0.1), about(0, 0.1), -1).normalized(), -about(1.15, 0.1)});    // floor
  planes_.push_back({Eigen::Vector3d(1, about(0, 0.1), about(-0.1, 0.1)).normalized(), -about(0.55, 0.1)});  // door
  planes_.push_back({Eigen::Vector3d(-1, about(0, 0.1), about(-0.1, 0.1)).normalized(), -about(0.75, 0.1)});
  planes_.push_back({Eigen::Vector3d(about(0, 0.1), 1, about(-0.4, 0.2)).normalized(), -about(0.9, 0.1)});  // rear
  const Eigen::Vector3d seat = vector(0.0, 0.05, 1.0, 0.06);
  const double recline = about(0.4, 0.15);
  add_box(seat, {0.26, 0.26, 0.07}, {about(0.1, 0.1), 0, about(0, 0.1)});
  add_box(seat + Eigen::Vector3d(0, -0.32, -0.25), {0.24, 0.07, 0.33}, {recline, 0, about(0, 0.1)});
  add_ellipsoid(seat + Eigen::Vector3d(0, -0.42, -0.58), {0.13, 0.05, 0.1}, {recline, 0, 0});
  add_box({about(0, 0.1), about(0.75, 0.05), about(0.75, 0.05)}, {0.7, 0.15, 0.3}, {about(0.3, 0.1), 0, 0});
  if (random.chance(0.2)) return;  // nobody there
  const double size = about(1.0, 0.2), lean = random.chance(0.3) ? about(0.2, 0.2) : 0.0;
  const Eigen::Vector3d hip = seat + Eigen::Vector3d(about(0, 0.05), -0.12, -0.12);
  const Eigen::Vector3d chest = hip + size * Eigen::Vector3d(about(0, 0.06), -0.12 + lean, -0.25);
  add_ellipsoid(chest, size * Eigen::Vector3d(0.2, 0.12, 0.27), {recline - 2 * lean, 0, about(0, 0.2)});
  add_ellipsoid(chest + size * Eigen::Vector3d(about(0, 0.05), 0.02 + lean, -0.36),
                size * vector(0.085, 0.1, 0.12, 0.01), vector(0, 0, 0, 0.3));
  for (const double side : {-1.0, 1.0}) {
    add_ellipsoid(hip + size * Eigen::Vector3d(side * 0.1, 0.25, about(-0.02, 0.03)),
                  size * Eigen::Vector3d(0.08, 0.25, 0.08), vector(0, 0, 0, 0.2));  // thigh
    add_ellipsoid(chest + size * Eigen::Vector3d(side * 0.24, about(0.12, 0.1), about(0, 0.1)),
                  size * Eigen::Vector3d(0.05, 0.16, 0.05), vector(0.3, 0, 0, 0.5));  // arm
  }
}

void CabinScene::add_ellipsoid(const Eigen::Vector3d& centre, const Eigen::Vector3d& radii,
                               const Eigen::Vector3d& turn) {
  ellipsoids_.push_back({centre, radii.cwiseInverse().asDiagonal() * turned(turn).transpose()});
}

void CabinScene::add_box(const Eigen::Vector3d& centre, const Eigen::Vector3d& half, const Eigen::Vector3d& turn) {
  boxes_.push_back({centre, half, turned(turn).transpose()});
}

std::optional<double> CabinScene::first_hit(const Line3& line, double from_m) const {
  double first = INFINITY;
  for (const Plane& plane : planes_) {
    const double t = (plane.offset_m - plane.normal.dot(line.point)) / plane.normal.dot(line.direction);
    if (t > from_m) first = std::min(first, t);
  }
  for (const Ellipsoid& ellipsoid : ellipsoids_) {
    const Eigen::Vector3d o = ellipsoid.sphere_from_rig * (line.point - ellipsoid.centre);
    const Eigen::Vector3d d = ellipsoid.sphere_from_rig * line.direction;
    const double a = d.squaredNorm(), b = o.dot(d), c = o.squaredNorm() - 1.0;
    if (b * b < a * c) continue;
    const double t = (-b - std::sqrt(b * b - a * c)) / a;
    if (t > from_m) first = std::min(first, t);
  }
  for (const Box& box : boxes_) {
    const Eigen::Array3d o = (box.box_from_rig * (line.point - box.centre)).array();
    const Eigen::Array3d d = (box.box_from_rig * line.direction).array();
    const Eigen::Array3d a = (-box.half.array() - o) / d, b = (box.half.array() - o) / d;
    const double enter = a.min(b).maxCoeff(), leave = a.max(b).minCoeff();
    if (enter <= leave && enter > from_m) first = std::min(first, enter);
  }
  return std::isfinite(first) ? std::optional(first) : std::nullopt;
}

bool CabinScene::visible(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const {
  const double distance = (to - from).norm();
  const auto hit = first_hit({from, (to - from) / distance}, 1e-6);
  return !hit || *hit > distance - 1e-4;
}

std::vector<SceneDot> dots_in(const CabinScene& scene, const RigCamera& camera, const std::vector<EmittedBeam>& beams,
                              const LaserGrid& grid, const SceneDotOptions& options, Random& random) {
  const Eigen::Vector3d eye = camera.camera_from_rig.inverse().translation;
  const double width = camera.camera.size.width - 1, height = camera.camera.size.height - 1;
  std::vector<SceneDot> dots;
  const auto add = [&](const Eigen::Vector2d& pixel, int beam, const Eigen::Vector3d& x_in_camera) {
    SceneDot dot{.dot = {}, .beam = beam, .x_in_camera = x_in_camera};
    const double u = random.normal(), v = random.normal();
    dot.dot.pixel = pixel + options.sigma_px * Eigen::Vector2d(u, v);
    const double sigma = std::max(options.sigma_px, 0.02);
    dot.dot.covariance_px2 = sigma * sigma * Eigen::Matrix2d::Identity();
    const Eigen::Vector2d inside = dot.dot.pixel.cwiseMax(0.0).cwiseMin(Eigen::Vector2d(width, height));
    if (inside == dot.dot.pixel) dots.push_back(dot);
  };
  for (const EmittedBeam& beam : beams) {
    const auto hit = scene.first_hit(beam.line, 0.02);
    if (!hit || !scene.visible(eye, beam.line.at(*hit))) continue;
    const Eigen::Vector3d x_in_camera = camera.camera_from_rig * beam.line.at(*hit);
    const auto pixel = pixel_from_ray(camera.camera, x_in_camera);
    if (pixel && !random.chance(options.missed)) {
      add(*pixel, beam.labelled() ? grid.index(beam.row, beam.column) : kUnlabelled, x_in_camera);
    }
  }
  const std::size_t seen = dots.size();
  for (std::size_t i = 0; i < seen; ++i) {
    if (!random.chance(options.spurious)) continue;
    const double u = random.uniform(0.0, width), v = random.uniform(0.0, height);
    add({u, v}, kUnlabelled, Eigen::Vector3d::Zero());
  }
  for (std::size_t i = dots.size(); i > 1; --i) std::swap(dots[i - 1], dots[random.below(static_cast<int>(i))]);
  return dots;
}

}  // namespace raybundle::testing
