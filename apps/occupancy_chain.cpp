// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "occupancy_chain.hpp"

#include <cmath>
#include <optional>

#include "raybundle/stereo/stereo.hpp"
#include "raybundle/structured_light/structured_light.hpp"
#include "thinning.hpp"

namespace raybundle::apps {

// An image as a camera gives it.
struct Bytes {
  ImageSize size;
  std::vector<std::uint8_t> values;

  GreyView view() const { return {values.data(), size.width, size.height, size.width}; }
};

namespace {

constexpr double kNearest_m = 0.25;  // that stereo looks for

Bytes bytes_of(const GreyImage& image) {
  Bytes bytes{image.size, {}};
  for (const std::uint16_t value : image.values) {
    bytes.values.push_back(static_cast<std::uint8_t>(value >> (image.bits - 8)));
  }
  return bytes;
}

CabinPart part_of(const CabinScene& scene, const CabinHit& hit) {
  return hit.mesh < 0 ? CabinPart::kCar : scene.cockpit().meshes[hit.mesh].part;
}

StereoOptions stereo_options(const Calibration& calibration) {
  StereoOptions options;
  const Rectification pair = rectify(calibration.cameras[0], calibration.cameras[1], options.rectify);
  const double most_px = disparity_from_distance(pair.camera, pair.baseline_m, pair.camera.centre_px.x(), kNearest_m);
  options.match.disparities = static_cast<int>(std::ceil(most_px)) + 2;
  return options;
}

}  // namespace

struct ChainSource::Runtime {
  std::optional<SensorTable> table;
  std::optional<StructuredLight> laser;
  std::optional<StereoMatcher> stereo;
};

ChainSource::ChainSource(const SceneRequest& request)
    : request_(request), sensor_(sensor_of(request)), renderer_(sensor_), runtime_(std::make_unique<Runtime>()) {
  const Calibration calibration = calibration_of(sensor_);
  if (request.kind == SensorKind::kStructuredLight) {
    runtime_->table = sensor_table(calibration, "", {}, "a simulated sensor");
    runtime_->laser.emplace(*runtime_->table);
  } else {
    runtime_->stereo.emplace(calibration, calibration.cameras[0].name, calibration.cameras[1].name,
                             stereo_options(calibration));
  }
}

ChainSource::ChainSource(ChainSource&&) noexcept = default;
ChainSource::~ChainSource() = default;

MeasuredScene ChainSource::at(double time_s) {
  CockpitRequest cockpit = request_.cockpit;
  cockpit.time_s = time_s;
  return measured(CabinScene(make_cockpit(cockpit)), time_s);
}

MeasuredScene ChainSource::measured(const CabinScene& scene, double time_s) {
  MeasuredScene measured;
  measured.layout = vehicle_layout(scene.cockpit().layout);
  measured.truth = scene.cockpit().truth;
  runtime_->laser ? measure_dots(scene, time_s, measured) : measure_pair(scene, time_s, measured);
  return measured;
}

Bytes ChainSource::image(const CabinScene& scene, int camera, bool laser, double time_s) const {
  const auto stream = static_cast<std::uint64_t>(std::lround(1e3 * time_s)) * 2 + (laser ? 1 : 0);
  return bytes_of(
      renderer_.image(scene, camera, {.seed = request_.cockpit.seed, .stream = stream, .laser = laser, .samples = 1}));
}

void ChainSource::measure_dots(const CabinScene& scene, double time_s, MeasuredScene& measured) {
  const SensorTable& table = *runtime_->table;
  const Rigid3& known = sensor_.known_vehicle_from_rig;
  const Rigid3 vehicle_from_camera = known * sensor_.rig.cameras[0].camera_from_rig.inverse();
  measured.viewpoint_in_vehicle = known * sensor_.rig.emitter->rig_from_emitter.translation;
  measured.rays = table.grid.size();
  std::vector<CabinHit> truth(static_cast<std::size_t>(measured.rays));
  for (const EmittedBeam& emitted : beams_of(*sensor_.rig.emitter)) {
    if (!emitted.labelled()) continue;
    const Line3 beam = sensor_.vehicle_from_rig * emitted.line;
    const auto hit = scene.first_hit(beam.point, beam.direction);
    if (hit) truth[table.grid.index(emitted.row, emitted.column)] = *hit;
  }
  const Bytes on = image(scene, 0, true, time_s), off = image(scene, 0, false, time_s);
  const LaserFrame& frame = runtime_->laser->process(on.view(), off.view());
  measured.state = frame.state;
  for (const LaserPoint& point : frame.points) {
    const TableBeam& beam = table.beams[point.beam];
    const int ray = table.grid.index(beam.row, beam.column);
    const CabinHit& hit = truth[ray];
    measured.points.push_back({ray, vehicle_from_camera * point.x_in_camera, std::sqrt(point.covariance.trace())});
    measured.parts.push_back(part_of(scene, hit));
    measured.true_points.push_back(hit.x_in_vehicle);
  }
}

void ChainSource::measure_pair(const CabinScene& scene, double time_s, MeasuredScene& measured) {
  const Bytes left = image(scene, 0, false, time_s), right = image(scene, 1, false, time_s);
  const StereoFrame frame = runtime_->stereo->process(left.view(), right.view());
  const Rigid3 rig_from_rectified = runtime_->stereo->rectification().rig_from_rectified;
  const Rigid3 vehicle_from_rectified = sensor_.known_vehicle_from_rig * rig_from_rectified;
  const Rigid3 true_from_rectified = sensor_.vehicle_from_rig * rig_from_rectified;
  std::vector<Eigen::Vector3d> directions;
  measured.viewpoint_in_vehicle = vehicle_from_rectified.translation;
  const int step = request_.most_points == 0 ? 1 : thinning_step(frame.disparity.matched, request_.most_points);
  const int columns = frame.points.width / step, rows = frame.points.height / step;
  measured.rays = columns * rows;
  measured.state = frame.state;
  for (int ray = 0; ray < measured.rays; ++ray) {
    const StereoPoint& point = frame.points.at(ray % columns * step, ray / columns * step);
    if (point.sigma_m == 0) continue;
    const Eigen::Vector3d x(point.x_m, point.y_m, point.z_m);
    measured.points.push_back({ray, vehicle_from_rectified * x, static_cast<double>(point.sigma_m)});
    directions.push_back(true_from_rectified.rotation * x.normalized());
  }
  std::vector<CabinHit> truth(directions.size());
  scene.first_hits(true_from_rectified.translation, directions, truth);
  for (const CabinHit& hit : truth) measured.parts.push_back(part_of(scene, hit));
}

}  // namespace raybundle::apps
