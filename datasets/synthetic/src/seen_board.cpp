// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "seen_board.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "view_geometry.hpp"

namespace raybundle {

SeenBoard::SeenBoard(const SimulatedBoard& board, const BoardScene& scene, const PrintCoverage& print,
                     const CameraRays& rays, const Rigid3& target_from_camera)
    : board_(&board),
      scene_(&scene),
      print_(&print),
      rays_(&rays),
      target_from_camera_(target_from_camera),
      rotation_(target_from_camera.rotation.toRotationMatrix()) {
  std::vector<Eigen::Vector3d> directions;
  directions.reserve(rays.corners().size());
  for (const Eigen::Vector3d& ray : rays.corners()) directions.push_back(rotation_ * ray);
  places_ = scene.places(target_from_camera.translation, directions);
}

bool SeenBoard::meets(int x, int y) const {
  if (!rays_->lit(x, y)) return false;
  const Eigen::Vector2d* place = &places_[rays_->corner(x, y)];
  const int below = rays_->columns();
  return !(std::isnan(place[0].x()) && std::isnan(place[1].x()) && std::isnan(place[below].x()) &&
           std::isnan(place[below + 1].x()));
}

Eigen::Vector2d SeenBoard::some_place(int x, int y) const {
  const Eigen::Vector2d* place = &places_[rays_->corner(x, y)];
  const int below = rays_->columns();
  for (const int i : {0, 1, below}) {
    if (!std::isnan(place[i].x())) return place[i];
  }
  return place[below + 1];
}

double SeenBoard::side(const Eigen::Vector2d& place) const {
  return scene_->normal(place).dot(eye() - scene_->on_surface(place)) > 0 ? 1.0 : -1.0;
}

std::optional<Quad> SeenBoard::quad(int x, int y) const {
  const Eigen::Vector2d* place = &places_[rays_->corner(x, y)];
  const int below = rays_->columns();
  const Quad quad{{place[0], place[1], place[below + 1], place[below]}};
  for (const Eigen::Vector2d& corner : quad.corners) {
    if (std::isnan(corner.x())) return std::nullopt;
  }
  return quad;
}

void SeenBoard::cell(const Quad& quad, bool printed, float& covered, float& albedo) const {
  const double area = quad.area();
  const double sheet = area > 0 ? std::min(1.0, area_in_box(quad, print_->sheet()) / area) : 0.0;
  const double ink = printed && sheet > 0 ? std::min(sheet, print_->ink_area(quad) / area) : 0.0;
  covered = static_cast<float>(sheet);
  albedo = static_cast<float>(sheet * board_->paper_albedo + ink * (board_->ink_albedo - board_->paper_albedo));
}

bool SeenBoard::cells(int x, int y, PixelCells& cells) const {
  if (!meets(x, y)) return false;
  constexpr int n = kCellsPerPixel;
  const bool printed = side(some_place(x, y)) * board_->print.front > 0;
  if (const auto whole = quad(x, y)) {
    const Eigen::Vector2d low = whole->low(), high = whole->high();
    const BoardPrint::Box& sheet = print_->sheet();
    if ((low.array() >= sheet.high.array()).any() || (high.array() <= sheet.low.array()).any()) return false;
    const int ink = printed ? print_->uniform(*whole) : 0;
    if (ink >= 0 && contains(sheet, low) && contains(sheet, high)) {
      std::fill_n(cells.covered, n * n, 1.0F);
      std::fill_n(cells.albedo, n * n, static_cast<float>(ink == 1 ? board_->ink_albedo : board_->paper_albedo));
      return true;
    }
  }
  std::array<std::optional<Eigen::Vector3d>, (n + 1) * (n + 1)> corner;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      corner[j * (n + 1) + i] =
          scene_->crossing(eye(), direction(x, y, static_cast<double>(i) / n, static_cast<double>(j) / n));
    }
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const auto* c = &corner[j * (n + 1) + i];
      float &covered = cells.covered[j * n + i], &albedo = cells.albedo[j * n + i];
      covered = albedo = 0;
      if (!c[0] || !c[1] || !c[n + 1] || !c[n + 2]) continue;
      cell({{c[0]->head<2>(), c[1]->head<2>(), c[n + 2]->head<2>(), c[n + 1]->head<2>()}}, printed, covered, albedo);
    }
  }
  return true;
}

}  // namespace raybundle
