// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "cabin_view.hpp"

#include <cmath>
#include <limits>
#include <vector>

namespace raybundle {
namespace {

constexpr double kFootprint = 2.0;            // 1/e² radii; beyond lie 3e-4 of a beam's power
constexpr int kRing = 12;                     // rays around the footprint
constexpr int kSamples = 2 * kCellsPerPixel;  // rays of a pixel, each way: spots are narrower than pixels

// Pixels around the places that the rim and the axis of a beam light.
struct Patch {
  int left = 0, top = 0, right = -1, bottom = -1;
};

Patch patch_of(const CabinScene& scene, const CabinView& view, const GaussianBeam& beam) {
  const Rigid3 camera_from_vehicle = view.vehicle_from_camera.inverse();
  const Eigen::Matrix<double, 3, 2> axes = across(beam.line.direction);
  const auto axis_hit = scene.first_hit(beam.line.point, beam.line.direction);
  const double radius_m = kFootprint * beam.radius_m(axis_hit ? axis_hit->distance_m : beam.waist_distance_m);
  Eigen::Array2d low(1e9, 1e9), high(-1e9, -1e9);
  for (int i = -1; i < kRing; ++i) {
    const double angle = 2 * M_PI * i / kRing, radius = i < 0 ? 0 : radius_m;
    const Eigen::Vector3d start = beam.line.point + radius * (axes * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    const auto hit = scene.first_hit(start, beam.line.direction);
    const auto pixel = hit ? pixel_from_ray(view.camera.camera, camera_from_vehicle * hit->x_in_vehicle) : std::nullopt;
    if (!pixel) continue;
    low = low.min(pixel->array());
    high = high.max(pixel->array());
  }
  const ImageSize size = view.camera.camera.size;
  const Eigen::Array2d first = (low - 0.5).floor().max(0),
                       last = (high + 0.5).ceil().min(Eigen::Array2d(size.width, size.height) - 1.0);
  if (!(first <= last).all()) return {};
  return {static_cast<int>(first.x()), static_cast<int>(first.y()), static_cast<int>(last.x()),
          static_cast<int>(last.y())};
}

}  // namespace

Eigen::Vector3d CabinView::direction(int x, int y, double u, double v) const {
  if (!rays.lit(x, y)) return Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  return vehicle_from_camera.rotation * rays.at(x, y, u, v).normalized();
}

void add_beam(const CabinScene& scene, const CabinView& view, const GaussianBeam& beam, const LensBlur& blur,
              LightImage& image) {
  const Patch patch = patch_of(scene, view, beam);
  if (patch.right < patch.left) return;
  CellLight cells(patch.left, patch.top, patch.right - patch.left + 1, patch.bottom - patch.top + 1);
  std::vector<Eigen::Vector3d> directions(kSamples * kSamples);
  std::vector<CabinHit> hits(directions.size());
  for (int y = patch.top; y <= patch.bottom; ++y) {
    for (int x = patch.left; x <= patch.right; ++x) {
      for (int k = 0; k < kSamples * kSamples; ++k) {
        const int column = k % kSamples, row = k / kSamples;
        directions[k] = view.direction(x, y, (column + 0.5) / kSamples, (row + 0.5) / kSamples);
      }
      scene.first_hits(view.eye(), directions, hits);
      for (int k = 0; k < kSamples * kSamples; ++k) {
        const CabinHit& hit = hits[k];
        if (hit.mesh < 0) continue;
        const double cosine = -hit.normal.dot(beam.line.direction), W_m2 = beam.irradiance_W_m2(hit.x_in_vehicle);
        if (cosine <= 0 || W_m2 < 1e-3) continue;
        const double along = (hit.x_in_vehicle - beam.line.point).dot(beam.line.direction);
        if (scene.blocked(hit.x_in_vehicle, hit.x_in_vehicle - along * beam.line.direction)) continue;
        constexpr int kEach = kSamples / kCellsPerPixel;
        cells.at(x, y, k % kSamples / kEach, k / kSamples / kEach) +=
            static_cast<float>(scene.albedo(hit) * cosine * W_m2 / (kEach * kEach));
      }
    }
  }
  blur.add(cells, image);
}

}  // namespace raybundle
