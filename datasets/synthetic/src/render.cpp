// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/synthetic/render.hpp"

#include <algorithm>
#include <cmath>

#include "laser_light.hpp"
#include "raybundle/synthetic/sensor.hpp"
#include "seen_board.hpp"
#include "view_geometry.hpp"

namespace raybundle {

struct ViewRenderer::Scene {
  SimulatedRig rig;
  std::vector<EmittedBeam> beams;
  BoardSurface surface;
  BoardScene board;
  PrintCoverage print;
  std::vector<LensBlur> blurs;   // for each camera
  std::vector<CameraRays> rays;  // for each camera

  Scene(const SimulatedRig& simulated, double warmer_K)
      : rig(simulated), surface(rig.board.target), board(rig.board), print(rig.board.print) {
    if (rig.emitter) beams = beams_of(warmer(*rig.emitter, warmer_K));
    for (const SimulatedCamera& camera : rig.cameras) {
      blurs.emplace_back(camera.sensor.lens_blur_px);
      rays.emplace_back(camera, blurs.back().reach());
    }
  }
};

namespace {

// Light without the laser.
class AmbientLight {
 public:
  AmbientLight(const SimulatedLight& light, const BoardScene& scene, const SeenBoard& seen,
               const Background& background, const Rigid3& target_from_rig)
      : light_(light),
        scene_(scene),
        seen_(seen),
        background_(background),
        sun_(target_from_rig.rotation * light.sun_direction.normalized()) {}

  // Light on the board times its albedo, and on what is behind it, into the pixel's cells.
  void shine(int x, int y, CellLight& cells) const {
    if (!seen_.lit(x, y)) return;
    constexpr int n = kCellsPerPixel;
    PixelCells board;
    const bool met = seen_.cells(x, y, board);
    const bool whole = met && *std::ranges::min_element(board.covered) >= 1.0F;
    const float on_board = met ? light_on_board(x, y) : 0.0F;
    const float behind = whole ? 0.0F : light_behind(x, y);
    for (int k = 0; k < n * n; ++k) {
      cells.at(x, y, k % n, k / n) = met ? board.albedo[k] * on_board + (1 - board.covered[k]) * behind : behind;
    }
  }

 private:
  float light_on_board(int x, int y) const {
    if (light_.sun_W_m2 == 0) return static_cast<float>(light_.ambient_W_m2);
    const Eigen::Vector2d place = seen_.some_place(x, y);
    const double cosine = seen_.side(place) * scene_.normal(place).dot(sun_);
    return static_cast<float>(light_.ambient_W_m2 + light_.sun_W_m2 * std::max(0.0, cosine));
  }

  float light_behind(int x, int y) const {
    double light_W_m2 = light_.ambient_W_m2;
    if (light_.sun_W_m2 > 0) {
      const Eigen::Vector3d place = background_.crossing(seen_.eye(), seen_.direction(x, y, 0.5, 0.5));
      const double cosine = background_.normal(place).dot(sun_);
      if (cosine > 0 && !scene_.sheet_crossing(place, sun_)) light_W_m2 += light_.sun_W_m2 * cosine;
    }
    return static_cast<float>(light_.background_albedo * light_W_m2);
  }

  const SimulatedLight& light_;
  const BoardScene& scene_;
  const SeenBoard& seen_;
  const Background& background_;
  Eigen::Vector3d sun_;  // towards it, in the target's frame
};

LightImage light_off(const SimulatedCamera& camera, const LensBlur& blur, const AmbientLight& ambient) {
  const ImageSize size = camera.camera.size;
  const int margin = blur.reach();
  CellLight cells(-margin, -margin, size.width + 2 * margin, size.height + 2 * margin);
  for (int y = -margin; y < size.height + margin; ++y) {
    for (int x = -margin; x < size.width + margin; ++x) ambient.shine(x, y, cells);
  }
  LightImage image(size);
  blur.add(cells, image);
  return image;
}

void vignette(const std::vector<float>& share, LightImage& image) {
  for (std::size_t i = 0; i < share.size(); ++i) image.values[i] *= share[i];
}

GaussianBeam beam_in_target(const EmittedBeam& beam, const Emitter& emitter, const Rigid3& target_from_rig) {
  return {target_from_rig * beam.line, beam.power_W, emitter.spot_radius_m, emitter.waist_distance_m,
          emitter.divergence_rad};
}

// Where a beam's spot is and whether the camera sees it.
std::optional<RenderedDot> dot_of(const GaussianBeam& beam, const SimulatedBoard& board, const BoardScene& scene,
                                  const SeenBoard& seen, const Background& background, const LaserLight& laser) {
  const auto on_board = scene.sheet_crossing(beam.line.point, beam.line.direction);
  const Eigen::Vector3d place = on_board ? *on_board : background.crossing(beam.line.point, beam.line.direction);
  const Eigen::Vector3d normal = on_board ? scene.normal(place.head<2>()) : background.normal(place);
  RenderedDot dot;
  dot.on_board = on_board.has_value();
  const double facing = -normal.dot(beam.line.direction);
  if (on_board) {
    const double side = seen.side(place.head<2>());
    if (side * facing <= 0) return std::nullopt;  // the beam lights the other side
    dot.on_ink = side * board.print.front > 0 && is_ink(board.print, place.head<2>());
  } else if (scene.sheet_crossing(seen.eye(), place - seen.eye())) {
    return std::nullopt;
  }
  const auto pixel = laser.pixel_of(place);
  if (!pixel) return std::nullopt;
  dot.pixel = *pixel;
  return dot;
}

std::vector<Observation> true_corners(const SimulatedRig& rig, const BoardSurface& surface,
                                      const SimulatedCamera& camera, const Rigid3& rig_from_target) {
  constexpr double kStatedSigma_px = 0.1;
  const PlacedBoard placed(rig.board, surface, rig_from_target);
  const std::vector<Eigen::Vector3d> points = points_on_surface(rig.board.target, rig.board.shape);
  std::vector<Observation> corners;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto pixel = placed.seen_at(camera, points[i]);
    if (pixel) corners.push_back({*pixel, kStatedSigma_px, rig.board.target.points[i].id});
  }
  return corners;
}

}  // namespace

ViewRenderer::ViewRenderer(const SimulatedRig& rig, double warmer_K)
    : scene_(std::make_shared<const Scene>(rig, warmer_K)) {}

const std::vector<EmittedBeam>& ViewRenderer::beams() const { return scene_->beams; }

RenderedView ViewRenderer::render(int camera_index, const Rigid3& rig_from_target, const RenderOptions& options) const {
  const SimulatedRig& rig = scene_->rig;
  const SimulatedCamera& camera = rig.cameras[camera_index];
  const CameraRays& rays = scene_->rays[camera_index];
  const LensBlur& blur = scene_->blurs[camera_index];
  const Rigid3 target_from_rig = rig_from_target.inverse();
  const SeenBoard seen(rig.board, scene_->board, scene_->print, rays,
                       target_from_rig * camera.camera_from_rig.inverse());
  const Background background(rig.light.background_m, target_from_rig);
  const auto key = [&](std::uint64_t purpose) { return random_key(options.seed, options.stream, purpose); };

  LightImage light = light_off(camera, blur, AmbientLight(rig.light, scene_->board, seen, background, target_from_rig));
  vignette(rays.vignetting(), light);
  RenderedView view;
  view.corners = true_corners(rig, scene_->surface, camera, rig_from_target);
  view.off = read_out(camera.sensor, light, options.noise, key(0));
  if (!rig.emitter) return view;

  LightImage laser_light(camera.camera.size);
  const LaserLight laser(rig, camera, scene_->board, seen, background, target_from_rig);
  for (std::size_t i = 0; i < scene_->beams.size(); ++i) {
    const GaussianBeam beam = beam_in_target(scene_->beams[i], *rig.emitter, target_from_rig);
    laser.add(beam, blur, laser_light);
    auto dot = dot_of(beam, rig.board, scene_->board, seen, background, laser);
    if (!dot) continue;
    dot->beam = static_cast<int>(i);
    view.dots.push_back(*dot);
  }
  vignette(rays.vignetting(), laser_light);
  for (RenderedDot& dot : view.dots) {
    const Eigen::Vector2i at = dot.pixel.array().round().cast<int>();
    const std::size_t i = static_cast<std::size_t>(at.y()) * camera.camera.size.width + at.x();
    dot.under_grey = grey_from_light(camera.sensor, light.values[i]);
    dot.peak_grey = grey_from_light(camera.sensor, laser_light.values[i]) - grey_from_light(camera.sensor, 0);
  }
  if (options.speckle) add_speckle(laser_light, rig.emitter->speckle_contrast, key(1));
  for (std::size_t i = 0; i < light.values.size(); ++i) light.values[i] += laser_light.values[i];
  view.on = read_out(camera.sensor, light, options.noise, key(2));
  return view;
}

RenderedView render_view(const SimulatedRig& rig, int camera, const Rigid3& rig_from_target,
                         const RenderOptions& options) {
  return ViewRenderer(rig).render(camera, rig_from_target, options);
}

}  // namespace raybundle
