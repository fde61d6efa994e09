// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/cockpit/cabin_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "cabin_lighting.hpp"
#include "cabin_view.hpp"
#include "pattern.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/synthetic/random.hpp"
#include "raybundle/synthetic/sensor.hpp"

namespace raybundle {

struct CabinRenderer::Tables {
  CabinSensor sensor;
  std::vector<EmittedBeam> beams;
  std::vector<LensBlur> blurs;   // for each camera
  std::vector<CameraRays> rays;  // for each camera

  explicit Tables(const CabinSensor& cabin_sensor) : sensor(cabin_sensor) {
    if (sensor.rig.emitter) beams = beams_of(*sensor.rig.emitter);
    for (const SimulatedCamera& camera : sensor.rig.cameras) {
      blurs.emplace_back(camera.sensor.lens_blur_px);
      rays.emplace_back(camera, blurs.back().reach());
    }
  }

  CabinView view(int camera) const {
    const SimulatedCamera& seeing = sensor.rig.cameras[camera];
    return {seeing, rays[camera], sensor.vehicle_from_rig * seeing.camera_from_rig.inverse()};
  }
};

namespace {

// A match needs so much texture over noise: below, its probability falls to zero.
constexpr double kTextureOverNoise = 2.0;
constexpr double kEdge_m = 0.05;       // neighbours that differ by more lie on two surfaces
constexpr double kSwallowed = 0.25;    // share of pixels beside an edge that get the nearer surface's depth
constexpr double kLost = 0.4;          // and that have no match
constexpr double kMostSigma_m = 0.15;  // along the ray: such points are of no use
constexpr double kNearest_m = 0.2, kFarthest_m = 2.0;  // of wrong matches

// The scene's light in the cells of a row of pixels and a margin.
void shine_row(const CabinScene& scene, const CabinView& view, const CabinLighting& lighting, int y, int samples,
               CellLight& cells) {
  const int first = cells.left(), end = first + cells.width(), n = samples * samples;
  std::vector<Eigen::Vector3d> directions;
  directions.reserve(static_cast<std::size_t>(cells.width()) * n);
  for (int x = first; x < end; ++x) {
    for (int k = 0; k < n; ++k) {
      directions.push_back(view.direction(x, y, (k % samples + 0.5) / samples, (k / samples + 0.5) / samples));
    }
  }
  std::vector<CabinHit> hits(directions.size());
  std::vector<float> light(directions.size());
  scene.first_hits(view.eye(), directions, hits);
  lighting.shine(view.eye(), hits, light);
  const int each = kCellsPerPixel / samples;
  for (int x = first; x < end; ++x) {
    const float* pixel = light.data() + static_cast<std::size_t>(x - first) * n;
    for (int j = 0; j < kCellsPerPixel; ++j) {
      for (int i = 0; i < kCellsPerPixel; ++i) cells.at(x, y, i, j) = pixel[j / each * samples + i / each];
    }
  }
}

bool within_field(const CabinView& view, int x, int y) {
  if (!view.rays.lit(x, y)) return false;
  const Eigen::Vector3d ray = view.rays.at(x, y, 0.5, 0.5);
  return std::atan2(ray.head<2>().norm(), ray.z()) <= view.camera.used_half_angle_rad;
}

bool sees(const CabinView& view, const CabinScene& scene, const Eigen::Vector3d& x_in_vehicle) {
  const Eigen::Vector3d ray = view.vehicle_from_camera.inverse() * x_in_vehicle;
  if (std::atan2(ray.head<2>().norm(), ray.z()) > view.camera.used_half_angle_rad) return false;
  const auto pixel = pixel_from_ray(view.camera.camera, ray);
  const ImageSize size = view.camera.camera.size;
  return pixel && pixel->x() > 0 && pixel->y() > 0 && pixel->x() < size.width - 1 && pixel->y() < size.height - 1 &&
         !scene.blocked(x_in_vehicle, view.eye());
}

// Distance of the nearest surface in the window when it is another one than the pixel's.
std::optional<double> swallowing(const CabinDepth& depth, int x, int y, int half_px) {
  const CabinHit& here = depth.hits[static_cast<std::size_t>(y) * depth.size.width + x];
  double nearest = here.distance_m - kEdge_m;
  bool found = false;
  for (int v = std::max(0, y - half_px); v <= std::min(depth.size.height - 1, y + half_px); ++v) {
    for (int u = std::max(0, x - half_px); u <= std::min(depth.size.width - 1, x + half_px); ++u) {
      const CabinHit& hit = depth.hits[static_cast<std::size_t>(v) * depth.size.width + u];
      if (hit.mesh < 0 || hit.distance_m >= nearest) continue;
      nearest = hit.distance_m;
      found = true;
    }
  }
  return found ? std::optional(nearest) : std::nullopt;
}

// The sensor with the exposure at which 1 % of the pixels are above 2/3 of the range.
//
// light  on the sensor [W/m² on a white surface]
SimulatedSensor exposed(const CabinSensor& sensor, int camera, std::vector<float> light) {
  constexpr double kMostChange = 8.0;
  SimulatedSensor exposed = sensor.rig.cameras[camera].sensor;
  if (!sensor.automatic_exposure) return exposed;
  const auto bright = light.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(light.size()));
  std::nth_element(light.begin(), bright, light.end());
  const double wanted = 0.67 * exposed.white_W_m2 / std::max(1e-6, static_cast<double>(*bright));
  exposed.exposure = std::clamp(wanted, exposed.exposure / kMostChange, exposed.exposure * kMostChange);
  return exposed;
}

// Probability that the texture of a surface is matched.
//
// light  on the sensor [W/m² on a white surface]
double match_chance(const SimulatedSensor& sensor, const CabinMaterial& material, double light) {
  const double electrons = sensor.full_well_e * sensor.exposure * light / sensor.white_W_m2;
  if (electrons >= sensor.full_well_e) return 0;
  const double noise = std::sqrt(electrons + sensor.read_noise_e * sensor.read_noise_e);
  return std::min(1.0, material.contrast * electrons / noise / kTextureOverNoise);
}

}  // namespace

CabinRenderer::CabinRenderer(const CabinSensor& sensor) : tables_(std::make_shared<const Tables>(sensor)) {}

const CabinSensor& CabinRenderer::sensor() const { return tables_->sensor; }

GreyImage CabinRenderer::image(const CabinScene& scene, int camera, const CabinImageOptions& options) const {
  if (options.samples != 1 && options.samples != 2 && options.samples != 4) {
    throw Error(ErrorKind::kBadInput, "CabinImageOptions::samples must be 1, 2 or 4");
  }
  const CabinView view = tables_->view(camera);
  const LensBlur& blur = tables_->blurs[camera];
  const CabinLighting lighting(scene, tables_->sensor);
  const ImageSize size = view.camera.camera.size;
  const int margin = blur.reach();
  CellLight cells(-margin, -margin, size.width + 2 * margin, size.height + 2 * margin);
  for (int y = -margin; y < size.height + margin; ++y) shine_row(scene, view, lighting, y, options.samples, cells);
  LightImage light(size);
  blur.add(cells, light);
  const auto key = [&](std::uint64_t purpose) {
    return random_key(options.seed, options.stream, purpose + 10 * static_cast<std::uint64_t>(camera));
  };
  const std::vector<float>& vignetting = view.rays.vignetting();
  const auto vignette = [&vignetting](LightImage& image) {
    for (std::size_t i = 0; i < vignetting.size(); ++i) image.values[i] *= vignetting[i];
  };
  vignette(light);
  const SimulatedSensor reading = exposed(tables_->sensor, camera, light.values);
  if (options.laser && tables_->sensor.rig.emitter) {
    const Emitter& emitter = *tables_->sensor.rig.emitter;
    LightImage laser(size);
    for (const EmittedBeam& beam : tables_->beams) {
      add_beam(scene, view,
               {tables_->sensor.vehicle_from_rig * beam.line, beam.power_W, emitter.spot_radius_m,
                emitter.waist_distance_m, emitter.divergence_rad},
               blur, laser);
    }
    vignette(laser);
    if (options.noise) add_speckle(laser, emitter.speckle_contrast, key(1));
    for (std::size_t i = 0; i < light.values.size(); ++i) light.values[i] += laser.values[i];
  }
  return read_out(reading, light, options.noise, key(options.laser ? 2 : 0));
}

CabinDepth CabinRenderer::depth(const CabinScene& scene, int camera) const {
  const CabinView view = tables_->view(camera);
  CabinDepth depth{view.camera.camera.size, {}};
  std::vector<Eigen::Vector3d> directions;
  for (int y = 0; y < depth.size.height; ++y) {
    for (int x = 0; x < depth.size.width; ++x) {
      directions.push_back(within_field(view, x, y)
                               ? view.direction(x, y, 0.5, 0.5)
                               : Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
    }
  }
  depth.hits.resize(directions.size());
  scene.first_hits(view.eye(), directions, depth.hits);
  return depth;
}

std::vector<CabinPoint> CabinRenderer::matched_points(const CabinScene& scene, const CabinMatchOptions& options) const {
  const CabinSensor& sensor = tables_->sensor;
  const CabinView left = tables_->view(0), right = tables_->view(1);
  const CabinLighting lighting(scene, sensor);
  const CabinDepth truth = depth(scene, 0);
  std::vector<float> light(truth.hits.size());
  lighting.shine(left.eye(), truth.hits, light);
  for (std::size_t i = 0; i < light.size(); ++i) light[i] *= left.rays.vignetting()[i];
  const SimulatedSensor reading = exposed(sensor, 0, light);
  const Rigid3 known_from_vehicle = sensor.known_vehicle_from_rig * sensor.vehicle_from_rig.inverse();
  const Eigen::Vector3d baseline = right.eye() - left.eye();
  Random random(options.seed, mixed_bits(options.stream) ^ 401);
  const auto noise_seed = static_cast<std::uint32_t>(random.below(1 << 30));
  std::vector<CabinPoint> points;
  for (int i = 0; i < static_cast<int>(truth.hits.size()); ++i) {
    const CabinHit& hit = truth.hits[i];
    if (hit.mesh < 0) continue;
    // Drawn for every pixel, so that one that is lost does not change the others.
    const double matched = random.uniform(), edge = random.uniform(), wrong = random.uniform(), alone = random.normal(),
                 anywhere = random.uniform();
    const int x = i % truth.size.width, y = i / truth.size.width;
    double distance = hit.distance_m;
    if (matched > match_chance(reading, scene.cockpit().meshes[hit.mesh].material, light[i])) continue;
    if (const auto nearer = edge < kSwallowed + kLost ? swallowing(truth, x, y, options.window_px / 2) : std::nullopt) {
      if (edge >= kSwallowed) continue;
      distance = *nearer;
    } else if (!sees(right, scene, hit.x_in_vehicle)) {
      continue;
    }
    const Eigen::Vector3d ray = (hit.x_in_vehicle - left.eye()) / hit.distance_m;
    const double across = (baseline - baseline.dot(ray) * ray).norm();
    const double per_px = distance * distance / (across * left.camera.camera.fx());
    const double sigma = options.disparity_sigma_px * per_px;
    if (sigma > kMostSigma_m) continue;
    const double alike = pattern_at({static_cast<float>(x), static_cast<float>(y), 0.0F}, 2.0, noise_seed);
    distance += sigma * (0.8 * alike + 0.6 * alone);
    if (wrong < options.wrong) distance = 1 / (1 / kFarthest_m + anywhere * (1 / kNearest_m - 1 / kFarthest_m));
    const double sideways = 0.3 * distance / left.camera.camera.fx();
    points.push_back({i, known_from_vehicle * (left.eye() + distance * ray),
                      sigma * sigma * ray * ray.transpose() + sideways * sideways * Eigen::Matrix3d::Identity(),
                      scene.cockpit().meshes[hit.mesh].part});
  }
  return points;
}

std::optional<Eigen::Vector3d> visible_head_centroid(const CabinDepth& depth, const Cockpit& cockpit,
                                                     const Eigen::Vector3d& eye) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double area = 0;
  for (const CabinHit& hit : depth.hits) {
    if (hit.mesh < 0 || cockpit.meshes[hit.mesh].part != CabinPart::kHead) continue;
    const double cosine = std::max(0.1, hit.normal.dot((eye - hit.x_in_vehicle).normalized()));
    const double shown = hit.distance_m * hit.distance_m / cosine;
    sum += shown * hit.x_in_vehicle;
    area += shown;
  }
  return area > 0 ? std::optional<Eigen::Vector3d>(sum / area) : std::nullopt;
}

}  // namespace raybundle
