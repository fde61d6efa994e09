// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "beam_hits.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "raybundle/scene/target_spacing.hpp"

namespace raybundle {
namespace {

constexpr double kMinCosine = 0.2;  // of the angle between ray and board normal
constexpr double kFloor_px = 0.1;   // of board poses and lens at the start, beside the dot's own covariance
constexpr double kMargin = 1.5;     // spacings: a chessboard's outermost squares and the white around them

/// Rays of one view against its board.
struct ViewGeometry {
  const Camera& camera;
  BoardSurface surface;
  BoardShape shape;
  Rigid3 target_from_camera;

  std::optional<Line3> line_in_target(const Eigen::Vector2d& pixel) const {
    const std::optional<Eigen::Vector3d> ray = ray_from_pixel(camera, pixel);
    if (!ray) return std::nullopt;
    return Line3{target_from_camera.translation, target_from_camera.rotation * *ray};
  }

  std::optional<Eigen::Vector3d> x_in_target(const Eigen::Vector2d& pixel) const {
    const std::optional<Line3> line = line_in_target(pixel);
    return line ? surface.crossing(*line, shape) : std::nullopt;
  }
};

ViewGeometry geometry_of(const LaserScene& scene, int v) {
  const TargetView& view = scene.problem.views[v];
  return {scene.cameras[view.camera], BoardSurface(scene.problem.targets[view.target]), scene.shapes[view.target],
          (scene.camera_from_rig[view.camera] * *scene.rig_from_target[v]).inverse()};
}

std::optional<BeamHit> hit_on_board(const ViewGeometry& geometry, const Rigid3& rig_from_target, const Dot& dot) {
  constexpr double kStep_px = 0.5;
  const std::optional<Line3> line = geometry.line_in_target(dot.pixel);
  const std::optional<Eigen::Vector3d> x = geometry.x_in_target(dot.pixel);
  if (!x || (*x - line->point).dot(line->direction) <= 0.0) return std::nullopt;
  const Eigen::Vector3d normal = geometry.surface.normal(x->x(), x->y(), geometry.shape).normalized();
  const double cosine = std::abs(normal.dot(line->direction));
  if (cosine < kMinCosine) return std::nullopt;
  Eigen::Matrix<double, 3, 2> wrt_pixel;
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d step = kStep_px * Eigen::Vector2d::Unit(axis);
    const std::optional<Eigen::Vector3d> ahead = geometry.x_in_target(dot.pixel + step);
    const std::optional<Eigen::Vector3d> behind = geometry.x_in_target(dot.pixel - step);
    if (!ahead || !behind) return std::nullopt;
    wrt_pixel.col(axis) = rig_from_target.rotation * (*ahead - *behind) / (2 * kStep_px);
  }
  const Eigen::Matrix2d covariance_px2 = dot.covariance_px2 + kFloor_px * kFloor_px * Eigen::Matrix2d::Identity();
  BeamHit hit;
  hit.x_in_rig = rig_from_target * *x;
  hit.covariance = wrt_pixel * covariance_px2 * wrt_pixel.transpose();
  hit.cosine = cosine;
  return hit;
}

}  // namespace

std::vector<std::vector<bool>> dots_on_boards(const LaserScene& scene) {
  std::vector<double> margins_m(scene.problem.targets.size(), 0.0);
  for (const TargetView& view : scene.problem.views) {
    double& margin_m = margins_m[view.target];
    if (!view.dots.empty() && margin_m == 0.0) margin_m = kMargin * spacing_m(scene.problem.targets[view.target]);
  }
  std::vector<std::vector<bool>> on;
  for (int v = 0; v < static_cast<int>(scene.problem.views.size()); ++v) {
    const TargetView& view = scene.problem.views[v];
    std::vector<bool>& of_view = on.emplace_back(view.dots.size(), false);
    if (view.dots.empty() || !scene.rig_from_target[v]) continue;
    const ViewGeometry geometry = geometry_of(scene, v);
    for (std::size_t d = 0; d < view.dots.size(); ++d) {
      const std::optional<Eigen::Vector3d> place = geometry.x_in_target(view.dots[d].pixel);
      of_view[d] = place && geometry.surface.covers(*place, margins_m[view.target]);
    }
  }
  return on;
}

std::vector<BeamHit> hits_on_boards(const LaserScene& scene, const std::vector<std::vector<bool>>& on_board) {
  std::vector<BeamHit> hits;
  for (int v = 0; v < static_cast<int>(scene.problem.views.size()); ++v) {
    const std::vector<Dot>& dots = scene.problem.views[v].dots;
    if (dots.empty() || !scene.rig_from_target[v]) continue;
    const ViewGeometry geometry = geometry_of(scene, v);
    for (int d = 0; d < static_cast<int>(dots.size()); ++d) {
      if (!on_board[v][d]) continue;
      std::optional<BeamHit> hit = hit_on_board(geometry, *scene.rig_from_target[v], dots[d]);
      if (!hit) continue;
      hit->view = v;
      hit->dot = d;
      hits.push_back(*hit);
    }
  }
  return hits;
}

std::optional<BeamHit> hit_at(const LaserScene& scene, int view, const Eigen::Vector2d& pixel) {
  if (!scene.rig_from_target[view]) return std::nullopt;
  return hit_on_board(geometry_of(scene, view), *scene.rig_from_target[view], {.pixel = pixel});
}

double squared_sigmas(const Line3& line, const BeamHit& hit, const Eigen::Matrix3d& line_covariance) {
  const Eigen::Matrix<double, 3, 2> basis = across(line.direction);
  const Eigen::Vector2d distance = basis.transpose() * (hit.x_in_rig - line.point);
  const Eigen::Matrix2d covariance = basis.transpose() * (hit.covariance + line_covariance) * basis;
  return distance.dot(covariance.inverse() * distance);
}

LaserBoards::LaserBoards(const LaserScene& scene) : scene_(scene) {
  surfaces_.resize(scene.problem.targets.size());
  for (const TargetView& view : scene.problem.views) {
    std::optional<BoardSurface>& surface = surfaces_[view.target];
    if (!view.dots.empty() && !surface) surface.emplace(scene.problem.targets[view.target]);
  }
  for (const std::optional<Rigid3>& pose : scene.rig_from_target) {
    target_from_rig_.push_back(pose ? std::optional(pose->inverse()) : std::nullopt);
  }
}

bool LaserBoards::expects_dot(int v, const Line3& line) const {
  const TargetView& view = scene_.problem.views[v];
  const BoardSurface& surface = *surfaces_[view.target];
  const std::optional<Eigen::Vector3d> x = surface.crossing(*target_from_rig_[v] * line, scene_.shapes[view.target]);
  if (!x || !surface.covers(*x)) return false;
  const Camera& camera = scene_.cameras[view.camera];
  const std::optional<Eigen::Vector2d> pixel =
      pixel_from_ray(camera, scene_.camera_from_rig[view.camera] * (*scene_.rig_from_target[v] * *x));
  return pixel && (pixel->array() > 2.0).all() && pixel->x() < camera.size.width - 3.0 &&
         pixel->y() < camera.size.height - 3.0;
}

}  // namespace raybundle
