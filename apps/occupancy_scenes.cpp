// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "occupancy_scenes.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "raybundle/cockpit/dots.hpp"

namespace raybundle::apps {
CabinSensor sensor_of(const SceneRequest& request) {
  const CockpitRequest& cockpit = request.cockpit;
  return request.kind == SensorKind::kStructuredLight
             ? structured_light_sensor(cockpit.generator, cockpit.seed, request.grid)
             : stereo_sensor(cockpit.generator, cockpit.seed, request.stereo_size);
}

VehicleLayout vehicle_layout(const CabinLayout& layout) {
  VehicleLayout vehicle{.dashboard_x_m = layout.dashboard_x_m,
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
  assert(layout.fixtures.size() <= vehicle.fixtures.size());
  std::ranges::copy(layout.fixtures, vehicle.fixtures.begin());
  return vehicle;
}

SeatPose seat_pose(const SeatSetting& seat) {
  return {{seat.bight.x(), seat.bight.z()}, seat.recline_rad, seat.cushion_pitch_rad};
}

SceneSource::SceneSource(const SceneRequest& request) : request_(request), sensor_(sensor_of(request)) {
  assert(request.kind == SensorKind::kStructuredLight);
}

MeasuredScene SceneSource::at(double time_s) const {
  CockpitRequest cockpit = request_.cockpit;
  cockpit.time_s = time_s;
  return measured(CabinScene(make_cockpit(cockpit)), time_s);
}

MeasuredScene SceneSource::measured(const CabinScene& scene, double time_s) const {
  MeasuredScene measured;
  measured.layout = vehicle_layout(scene.cockpit().layout);
  measured.truth = scene.cockpit().truth;
  measured.viewpoint_in_vehicle = sensor_.known_vehicle_from_rig * sensor_.rig.emitter->rig_from_emitter.translation;
  measured.rays = sensor_.rig.emitter->grid.size();
  const auto frame = static_cast<std::uint64_t>(std::lround(1e3 * time_s));
  const std::vector<CabinDot> dots = dots_of(scene, sensor_, {.seed = request_.cockpit.seed, .stream = frame});
  std::vector<Eigen::Vector3d> truth(static_cast<std::size_t>(measured.rays), Eigen::Vector3d::Zero());
  for (const CabinDot& dot : dots) {
    if (dot.dot.beam != kUnlabelled) truth[dot.dot.beam] = dot.x_in_vehicle;
  }
  for (const CabinPoint& point : points_of(dots, sensor_)) {
    measured.points.push_back({point.ray, point.x_in_vehicle, std::sqrt(point.covariance_m2.trace())});
    measured.parts.push_back(point.part);
    measured.true_points.push_back(truth[point.ray]);
  }
  return measured;
}

MeasuredScene measured_scene(const SceneRequest& request) { return SceneSource(request).at(request.cockpit.time_s); }

}  // namespace raybundle::apps
