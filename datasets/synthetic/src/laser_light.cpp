// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "laser_light.hpp"

#include <algorithm>
#include <cmath>

namespace raybundle {
namespace {

constexpr double kFootprint = 2.8;   // 1/e² radii; beyond lie 2e-7 of a beam's power
constexpr int kRing = 16;            // points around a footprint
constexpr double kFinestStep = 0.8;  // of samples, over the spot's standard deviation
constexpr int kMostSamples = 4;      // in a cell, each way

// Offsets across a beam: its axis and a ring.
std::vector<Eigen::Vector3d> ring_offsets(const Eigen::Vector3d& direction, double radius_m) {
  const Eigen::Matrix<double, 3, 2> axes = across(direction);
  std::vector<Eigen::Vector3d> offsets{Eigen::Vector3d::Zero()};
  for (int i = 0; i < kRing; ++i) {
    const double angle = 2 * M_PI * i / kRing;
    offsets.push_back(radius_m * (axes * Eigen::Vector2d(std::cos(angle), std::sin(angle))));
  }
  return offsets;
}

// Samples in a cell, each way, so that a spot of that standard deviation is not under-sampled.
int samples_for(double sigma_px) {
  const double cells = 1.0 / (kCellsPerPixel * kFinestStep * std::max(sigma_px, 1e-6));
  return std::clamp(static_cast<int>(std::ceil(cells)), 1, kMostSamples);
}

// Mean of light(u, v) over a cell of the pixel.
template <typename Light>
float mean_over_cell(int i, int j, int samples, Light&& light) {
  double sum = 0;
  for (int b = 0; b < samples; ++b) {
    for (int a = 0; a < samples; ++a) {
      sum += light((i + (a + 0.5) / samples) / kCellsPerPixel, (j + (b + 0.5) / samples) / kCellsPerPixel);
    }
  }
  return static_cast<float>(sum / (samples * samples));
}

}  // namespace

Eigen::Vector3d Background::crossing(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
  const Eigen::Vector3d from_centre = origin - centre_;
  const double a = direction.squaredNorm(), half_b = from_centre.dot(direction);
  const double c = from_centre.squaredNorm() - radius_m_ * radius_m_;
  return origin + (-half_b + std::sqrt(std::max(0.0, half_b * half_b - a * c))) / a * direction;
}

// Pixels around a spot.
struct LaserLight::Patch {
  int left = 0, top = 0, width = 0, height = 0;
  double sigma_px = 0.0;  // of the spot along its narrow side

  bool empty() const { return width <= 0 || height <= 0; }
};

LaserLight::LaserLight(const SimulatedRig& rig, const SimulatedCamera& camera, const BoardScene& scene,
                       const SeenBoard& seen, const Background& background, const Rigid3& target_from_rig)
    : rig_(&rig),
      camera_(&camera),
      scene_(&scene),
      seen_(&seen),
      background_(&background),
      camera_from_target_(camera.camera_from_rig * target_from_rig.inverse()) {}

std::optional<Eigen::Vector2d> LaserLight::pixel_of(const Eigen::Vector3d& x_in_target) const {
  auto pixel = pixel_from_ray(camera_->camera, camera_from_target_ * x_in_target);
  const ImageSize size = camera_->camera.size;
  if (!pixel ||
      !(pixel->x() > -0.5 && pixel->y() > -0.5 && pixel->x() < size.width - 0.5 && pixel->y() < size.height - 0.5)) {
    return std::nullopt;
  }
  return pixel;
}

// The first of the places is the spot's centre.
LaserLight::Patch LaserLight::patch_around(const std::vector<Eigen::Vector3d>& places) const {
  const ImageSize size = camera_->camera.size;
  Eigen::Array2d low(1e9, 1e9), high(-1e9, -1e9);
  std::optional<Eigen::Vector2d> centre;
  double narrow_px = 1e9;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto pixel = pixel_from_ray(camera_->camera, camera_from_target_ * places[i]);
    if (!pixel) continue;
    if (i == 0) centre = pixel;
    if (i > 0 && centre) narrow_px = std::min(narrow_px, (*pixel - *centre).norm());
    low = low.min(pixel->array());
    high = high.max(pixel->array());
  }
  const int margin = seen_->margin();
  const Eigen::Array2d first = (low - 0.5).floor().max(-margin);
  const Eigen::Array2d last = (high + 0.5).ceil().min(Eigen::Array2d(size.width, size.height) - 1.0 + margin);
  if (!(first <= last).all()) return {};
  const Eigen::Array2i corner = first.cast<int>(), extent = (last - first + 1).cast<int>();
  return {corner.x(), corner.y(), extent.x(), extent.y(), narrow_px / (2 * kFootprint)};
}

void LaserLight::add(const GaussianBeam& beam, const LensBlur& blur, LightImage& image) const {
  const Eigen::Vector3d behind = background_->crossing(beam.line.point, beam.line.direction);
  const auto on_board = scene_->crossing(beam.line.point, beam.line.direction);
  const auto offsets_at = [&](const Eigen::Vector3d& place) {
    return ring_offsets(beam.line.direction, kFootprint * beam.radius_m((place - beam.line.point).norm()));
  };
  if (on_board) add_on_board(beam, offsets_at(*on_board), blur, image);
  add_behind(beam, offsets_at(behind), blur, image);
}

void LaserLight::add_on_board(const GaussianBeam& beam, const std::vector<Eigen::Vector3d>& offsets,
                              const LensBlur& blur, LightImage& image) const {
  std::vector<Eigen::Vector3d> places;
  for (const Eigen::Vector3d& offset : offsets) {
    const auto place = scene_->crossing(beam.line.point + offset, beam.line.direction);
    if (place) places.push_back(*place);
  }
  if (!scene_->near_sheet(places)) return;
  const Patch patch = patch_around(places);
  if (patch.empty()) return;
  CellLight light(patch.left, patch.top, patch.width, patch.height);
  const int samples = samples_for(patch.sigma_px);
  PixelCells cells;
  for (int y = patch.top; y < patch.top + patch.height; ++y) {
    for (int x = patch.left; x < patch.left + patch.width; ++x) {
      if (!seen_->cells(x, y, cells)) continue;
      const double side = seen_->side(seen_->some_place(x, y));
      const auto irradiance = [&](double u, double v) {
        const auto place = scene_->crossing(seen_->eye(), seen_->direction(x, y, u, v));
        if (!place) return 0.0;
        const double cosine = -side * scene_->normal(place->head<2>()).dot(beam.line.direction);
        return cosine > 0 ? cosine * beam.irradiance_W_m2(*place) : 0.0;
      };
      for (int k = 0; k < kCellsPerPixel * kCellsPerPixel; ++k) {
        const int i = k % kCellsPerPixel, j = k / kCellsPerPixel;
        if (cells.albedo[k] > 0) light.at(x, y, i, j) = cells.albedo[k] * mean_over_cell(i, j, samples, irradiance);
      }
    }
  }
  blur.add(light, image);
}

LaserLight::Shadow LaserLight::shadow_of(const GaussianBeam& beam, const std::vector<Eigen::Vector3d>& offsets) const {
  const auto blocked = std::ranges::count_if(offsets, [&](const Eigen::Vector3d& offset) {
    return scene_->sheet_crossing(beam.line.point + offset, beam.line.direction).has_value();
  });
  if (blocked == 0) return Shadow::kNone;
  return blocked == static_cast<std::ptrdiff_t>(offsets.size()) ? Shadow::kWhole : Shadow::kPart;
}

void LaserLight::add_behind(const GaussianBeam& beam, const std::vector<Eigen::Vector3d>& offsets, const LensBlur& blur,
                            LightImage& image) const {
  const Shadow shadow = shadow_of(beam, offsets);
  if (shadow == Shadow::kWhole) return;
  std::vector<Eigen::Vector3d> places;
  for (const Eigen::Vector3d& offset : offsets) {
    places.push_back(background_->crossing(beam.line.point + offset, beam.line.direction));
  }
  const Patch patch = patch_around(places);
  if (patch.empty()) return;
  CellLight light(patch.left, patch.top, patch.width, patch.height);
  const int samples = samples_for(patch.sigma_px);
  const auto albedo = static_cast<float>(rig_->light.background_albedo);
  PixelCells cells;
  for (int y = patch.top; y < patch.top + patch.height; ++y) {
    for (int x = patch.left; x < patch.left + patch.width; ++x) {
      if (!seen_->lit(x, y)) continue;
      if (!seen_->cells(x, y, cells)) std::ranges::fill(cells.covered, 0.0F);
      const auto irradiance = [&](double u, double v) {
        const Eigen::Vector3d place = background_->crossing(seen_->eye(), seen_->direction(x, y, u, v));
        const double light_W_m2 = beam.irradiance_W_m2(place);
        if (shadow == Shadow::kPart) {
          const Eigen::Vector3d start =
              place - (place - beam.line.point).dot(beam.line.direction) * beam.line.direction;
          if (scene_->sheet_crossing(start, beam.line.direction)) return 0.0;
        }
        return light_W_m2 * std::max(0.0, -background_->normal(place).dot(beam.line.direction));
      };
      for (int k = 0; k < kCellsPerPixel * kCellsPerPixel; ++k) {
        const int i = k % kCellsPerPixel, j = k / kCellsPerPixel;
        const float open = 1 - cells.covered[k];
        if (open > 0) light.at(x, y, i, j) = open * albedo * mean_over_cell(i, j, samples, irradiance);
      }
    }
  }
  blur.add(light, image);
}

}  // namespace raybundle
