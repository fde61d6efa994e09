// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "view_geometry.hpp"

#include <algorithm>
#include <cmath>

namespace raybundle {
namespace {

constexpr double kSettled_m = 1e-9;
constexpr double kSmallestCosine = 0.15;  // what is seen flatter than 81° is not measured

bool within_image(const Eigen::Vector2d& pixel, ImageSize size) {
  return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= size.width - 1 && pixel.y() <= size.height - 1;
}

}  // namespace

bool contains(const BoardPrint::Box& box, const Eigen::Vector2d& place) {
  return (place.array() >= box.low.array()).all() && (place.array() <= box.high.array()).all();
}

bool is_ink(const BoardPrint& print, const Eigen::Vector2d& place) {
  const auto in_box = [&](const BoardPrint::Box& box) { return contains(box, place); };
  const auto in_disc = [&](const BoardPrint::Disc& disc) { return (place - disc.centre).norm() <= disc.radius; };
  const bool in_shape = std::ranges::any_of(print.boxes, in_box) || std::ranges::any_of(print.discs, in_disc);
  return print.ground ? contains(*print.ground, place) && !in_shape : in_shape;
}

double PlacedBoard::facing(const Eigen::Vector3d& x_in_target, const Eigen::Vector3d& towards) const {
  const Eigen::Vector3d normal =
      board_->print.front * surface_->normal(x_in_target.x(), x_in_target.y(), board_->shape).normalized();
  return normal.dot((towards - x_in_target).normalized());
}

std::optional<Eigen::Vector2d> PlacedBoard::seen_at(const SimulatedCamera& camera,
                                                    const Eigen::Vector3d& x_in_target) const {
  const Rigid3 camera_from_target = camera.camera_from_rig * rig_from_target_;
  const Eigen::Vector3d ray = camera_from_target * x_in_target;
  if (angle_off_axis(ray) > camera.used_half_angle_rad) return std::nullopt;
  if (facing(x_in_target, camera_from_target.inverse().translation) < kSmallestCosine) return std::nullopt;
  const auto pixel = pixel_from_ray(camera.camera, ray);
  return pixel && within_image(*pixel, camera.camera.size) ? pixel : std::nullopt;
}

std::optional<Eigen::Vector3d> PlacedBoard::spot(const Line3& beam_in_rig) const {
  const Line3 beam = rig_from_target_.inverse() * beam_in_rig;
  auto place = surface_->crossing(beam, board_->shape);
  if (!place || !contains(board_->print.sheet, place->head<2>())) return std::nullopt;
  // A line that passes a bent board far outside of it may not have settled on the surface.
  if (std::abs(place->z() - surface_->height(place->x(), place->y(), board_->shape)) > kSettled_m) return std::nullopt;
  if ((*place - beam.point).dot(beam.direction) <= 0) return std::nullopt;
  if (facing(*place, beam.point) < kSmallestCosine) return std::nullopt;
  return place;
}

double PlacedBoard::pixel_area_m2(const SimulatedCamera& camera, const Eigen::Vector3d& x_in_target) const {
  const Rigid3 camera_from_target = camera.camera_from_rig * rig_from_target_;
  const double distance = (camera_from_target * x_in_target).norm();
  const double cosine = std::max(kSmallestCosine, facing(x_in_target, camera_from_target.inverse().translation));
  return distance * distance / (camera.camera.fx() * camera.camera.fy() * cosine);
}

}  // namespace raybundle
