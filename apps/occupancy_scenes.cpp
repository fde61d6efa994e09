// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "occupancy_scenes.hpp"

#include <cmath>

#include "raybundle/cockpit/cabin_renderer.hpp"
#include "raybundle/cockpit/dots.hpp"

namespace raybundle::apps {
namespace {

std::uint64_t frame_of(const SceneRequest& request) {
  return static_cast<std::uint64_t>(std::lround(1e3 * request.cockpit.time_s));
}

void add(const CabinPoint& point, MeasuredScene& measured) {
  measured.points.push_back({point.ray, point.x_in_vehicle, std::sqrt(point.covariance_m2.trace())});
  measured.parts.push_back(point.part);
}

void measure_dots(const SceneRequest& request, const CabinScene& scene, MeasuredScene& measured) {
  const std::uint64_t seed = request.cockpit.seed;
  const CabinSensor sensor = structured_light_sensor(request.cockpit.generator, seed, request.grid);
  const std::vector<CabinDot> dots = dots_of(scene, sensor, {.seed = seed, .stream = frame_of(request)});
  measured.viewpoint_in_vehicle = sensor.known_vehicle_from_rig * sensor.rig.emitter->rig_from_emitter.translation;
  measured.rays = request.grid.size();
  std::vector<Eigen::Vector3d> truth(static_cast<std::size_t>(measured.rays), Eigen::Vector3d::Zero());
  for (const CabinDot& dot : dots) {
    if (dot.dot.beam != kUnlabelled) truth[dot.dot.beam] = dot.x_in_vehicle;
  }
  for (const CabinPoint& point : points_of(dots, sensor)) {
    add(point, measured);
    measured.true_points.push_back(truth[point.ray]);
  }
}

void measure_stereo(const SceneRequest& request, const CabinScene& scene, MeasuredScene& measured) {
  const std::uint64_t seed = request.cockpit.seed;
  const CabinRenderer renderer(stereo_sensor(request.cockpit.generator, seed, request.stereo_size));
  measured.viewpoint_in_vehicle = renderer.sensor().known_vehicle_from_rig.translation;
  measured.rays = request.stereo_size.width * request.stereo_size.height;
  for (const CabinPoint& point : renderer.matched_points(scene, {.seed = seed, .stream = frame_of(request)})) {
    add(point, measured);
  }
}

}  // namespace

VehicleLayout vehicle_layout(const CabinLayout& layout) {
  return {.dashboard_x_m = layout.dashboard_x_m,
          .dashboard_top_m = layout.dashboard_top_m,
          .zone_floor_m = layout.zone_floor_m,
          .zone_half_width_m = layout.zone_half_width_m,
          .critical_m = layout.critical_m,
          .out_of_position_m = layout.out_of_position_m,
          .track_m = layout.track_m,
          .lift_m = layout.lift_m,
          .least_recline_rad = layout.least_recline_rad,
          .most_recline_rad = layout.most_recline_rad,
          .roof_m = layout.roof_m};
}

MeasuredScene measured_scene(const SceneRequest& request) {
  const CabinScene scene(make_cockpit(request.cockpit));
  MeasuredScene measured;
  measured.layout = vehicle_layout(scene.cockpit().layout);
  measured.truth = scene.cockpit().truth;
  request.kind == SensorKind::kStructuredLight ? measure_dots(request, scene, measured)
                                               : measure_stereo(request, scene, measured);
  return measured;
}

}  // namespace raybundle::apps
