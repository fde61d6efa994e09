// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/cockpit/cabin_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cabin_lighting.hpp"
#include "cabin_view.hpp"
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

// The scene's light in the cells of a row of pixels and a margin.
void shine_row(const CabinScene& scene, const CabinView& view, const CabinLighting& lighting, int y, int samples,
               CellLight& cells) {
  const int first = cells.left(), end = first + cells.width(), n = samples * samples;
  std::vector<Eigen::Vector3d> directions;
  directions.reserve(static_cast<std::size_t>(cells.width()) * n);
  for (int x = first; x < end; ++x) {
    for (int k = 0; k < n; ++k) {
      const int column = k % samples, row = k / samples;
      directions.push_back(view.direction(x, y, (column + 0.5) / samples, (row + 0.5) / samples));
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
  return angle_off_axis(ray) <= view.camera.used_half_angle_rad;
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
