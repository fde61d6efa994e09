// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/structured_light/sensor_table.hpp"

#include <algorithm>
#include <cmath>

#include "candidate_lists.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/rotation.hpp"
#include "raybundle/scene/parameter_names.hpp"
#include "raybundle/structured_light/beam_geometry.hpp"

namespace raybundle {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kCurveStep_px = 2.0;
constexpr double kFarAway_m = 1e4;  // dots beyond the range have to be told from those in it
constexpr std::size_t kSelfTests = 64;
constexpr double kForeseenAt_m = 0.6;   // along a foreseen beam: amid the depths of a cabin
constexpr double kExtrapolation = 4.0;  // of a variance: beams that were not seen lie at the model's rim
constexpr double kLeastGap_m = 1e-3;    // between camera and beam: nearer, a dot tells no depth

// The covariance of a line's motion in another frame: the vectors across it are others there.
Eigen::Matrix4d turned(const Eigen::Matrix4d& covariance, const Rigid3& b_from_a, const Line3& in_a,
                       const Line3& in_b) {
  const Eigen::Matrix2d turn =
      across(in_b.direction).transpose() * b_from_a.rotation.toRotationMatrix() * across(in_a.direction);
  Eigen::Matrix4d both = Eigen::Matrix4d::Zero();
  both.topLeftCorner<2, 2>() = turn;
  both.bottomRightCorner<2, 2>() = turn;
  return both * covariance * both.transpose();
}

// What the calibration leaves uncertain of the camera's place on the rig, as a motion of the beams before it. There the
// rig turns about its own origin, here about the camera's centre.
Matrix6 of_place(const Calibration& calibration, const RigCamera& camera) {
  Matrix6 about_centre = Matrix6::Identity();
  about_centre.bottomLeftCorner<3, 3>() = skew(camera.camera_from_rig.translation);
  return about_centre * calibration.covariance.block(extrinsic_names(camera)) * about_centre.transpose();
}

// The covariance of a line that moves with others: rotation about the camera's centre, translation.
Eigen::Matrix4d shared_by(const Line3& line, const Matrix6& motion) {
  const Eigen::Matrix<double, 2, 3> sideways = across(line.direction).transpose();
  Eigen::Matrix<double, 4, 6> by_motion;
  by_motion << -sideways * skew(line.point), sideways,  //
      -sideways * skew(line.direction), Eigen::Matrix<double, 2, 3>::Zero();
  return by_motion * motion * by_motion.transpose();
}

// How the wavelength moves a calibrated beam, by the grating's model.
Eigen::Vector4d per_wavelength(const LaserPattern& laser, int row, int column, const Rigid3& camera_from_rig,
                               const Line3& line) {
  if (!laser.grating) return Eigen::Vector4d::Zero();
  constexpr double kStep = 1e-5;
  const double m = column - laser.zero_order_column, n = row - laser.zero_order_row;
  Grating longer = *laser.grating, shorter = longer;
  longer.wavelength_scale *= 1.0 + kStep;
  shorter.wavelength_scale *= 1.0 - kStep;
  const auto to = beam_of_order(longer, m, n), from = beam_of_order(shorter, m, n);
  if (!to || !from) return Eigen::Vector4d::Zero();
  return (motion_between(line, camera_from_rig * *to) - motion_between(line, camera_from_rig * *from)) / (2.0 * kStep);
}

// Where the dots of a beam may be seen, sigma by sigma of the wavelength: the drift covers what is between.
std::vector<CurvePoint> curves_by_wavelength(const Camera& camera, const TableBeam& beam, const SensorRange& range) {
  const int most = beam.per_wavelength.isZero() ? 0 : kWavelengthSigmas;
  std::vector<CurvePoint> all;
  for (int sigmas = -most; sigmas <= most; ++sigmas) {
    const Line3 line = perturbed(beam.line, sigmas * kLogWavelengthSigma * beam.per_wavelength);
    const auto curve = beam_curve(camera, line, {range.explained_from_m(), kFarAway_m}, kCurveStep_px);
    all.insert(all.end(), curve.begin(), curve.end());
  }
  return all;
}

void require_sense(const SensorRange& range) {
  if (!(range.nearest_m >= 0.01) || !(range.farthest_m > range.nearest_m) || !(range.farthest_m <= 1000.0)) {
    throw Error(ErrorKind::kBadInput, "the depths must be from 0.01 to 1000 m, the nearest below the farthest");
  }
  if (!(range.tolerance_px > 0.0) || !(range.tolerance_px <= 20.0)) {
    throw Error(ErrorKind::kBadInput, "the tolerance must be above 0 and at most 20 px");
  }
}

void add_beams(const LaserPattern& laser, const RigCamera& camera, SensorTable& table) {
  const Rigid3& camera_from_rig = camera.camera_from_rig;
  Eigen::Matrix4d off_model = Eigen::Matrix4d::Zero();  // mean square of the calibrated beams off the grating's model
  std::vector<char> known(laser.grid.size());
  for (const LaserBeam& beam : laser.beams) {
    const Line3 line = camera_from_rig * beam.line;
    if (line.point.cross(line.direction).norm() < kLeastGap_m) {
      throw Error(ErrorKind::kBadInput, "beam " + std::to_string(beam.row) + ", " + std::to_string(beam.column) +
                                            " passes through camera " + camera.name +
                                            ", so that its dots tell no depth; give another --camera");
    }
    known[laser.grid.index(beam.row, beam.column)] = 1;
    const Eigen::Matrix4d own = turned(beam.covariance, camera_from_rig, beam.line, line);
    table.beams.push_back({beam.row, beam.column, true, line, own + shared_by(line, table.shared_covariance),
                           per_wavelength(laser, beam.row, beam.column, camera_from_rig, line)});
    if (const auto model = line_of_model(laser, beam.row, beam.column)) {
      const Eigen::Vector4d motion = motion_between(line, camera_from_rig * *model);
      off_model += motion * motion.transpose() / static_cast<double>(laser.beams.size());
    }
  }
  for (int b = 0; b < laser.grid.size(); ++b) {
    const int row = laser.grid.row(b), column = laser.grid.column(b);
    const auto model = known[b] ? std::nullopt : line_of_model(laser, row, column);
    if (!model) continue;
    const Line3 line = camera_from_rig * Line3{model->at(kForeseenAt_m), model->direction};
    table.beams.push_back({row, column, false, line,
                           kExtrapolation * off_model + shared_by(line, table.shared_covariance),
                           per_wavelength(laser, row, column, camera_from_rig, line)});
  }
  std::ranges::sort(table.beams, {}, [](const TableBeam& beam) { return std::pair(beam.row, beam.column); });
}

}  // namespace

SensorTable sensor_table(const Calibration& calibration, const std::string& camera_name, const SensorRange& range,
                         const std::string& origin) {
  if (!calibration.laser || calibration.laser->beams.empty() || calibration.cameras.empty()) {
    throw Error(ErrorKind::kBadInput, "the calibration holds no laser beams; calibrate with a [laser] section");
  }
  const LaserGrid& grid = calibration.laser->grid;
  if (grid.size() > kMostBeams) {
    throw Error(ErrorKind::kBadInput, "a laser of " + std::to_string(grid.rows) + " rows and " +
                                          std::to_string(grid.columns) +
                                          " columns has more beams than a table holds, " + std::to_string(kMostBeams));
  }
  require_sense(range);
  const RigCamera& camera = camera_name.empty() ? calibration.cameras.front() : camera_named(calibration, camera_name);
  SensorTable table;
  table.camera = camera.name;
  table.origin = origin;
  table.range = range;
  table.rays = ray_table(camera.camera);
  table.grid = grid;
  table.shared_covariance = of_place(calibration, camera);
  add_beams(*calibration.laser, camera, table);

  std::vector<std::vector<CurvePoint>> curves, endless;
  for (const TableBeam& beam : table.beams) {
    curves.push_back(beam_curve(camera.camera, beam.line, range, kCurveStep_px));
    endless.push_back(curves_by_wavelength(camera.camera, beam, range));
  }
  table.candidates = candidate_lists(camera.camera.size, endless, range.tolerance_px + table.drift_px + kCurveStep_px);
  std::size_t seen = 0;
  for (const auto& curve : curves) seen += !curve.empty();
  if (seen == 0) {
    throw Error(ErrorKind::kNotEnoughData, "camera " + camera.name + " sees no beam within these depths; widen them");
  }
  const std::size_t every = std::max<std::size_t>(1, seen / kSelfTests);
  for (std::size_t beam = 0; beam < curves.size(); beam += every) {
    if (curves[beam].empty()) continue;
    const CurvePoint& point = curves[beam][beam * 7 % curves[beam].size()];  // any depth of the curve
    if ((point.pixel.array() < 0.0).any() || point.pixel.x() > camera.camera.size.width - 1 ||
        point.pixel.y() > camera.camera.size.height - 1 || std::isnan(table.rays.at(point.pixel).direction.x())) {
      continue;
    }
    table.self_tests.push_back(
        {point.pixel, *ray_from_pixel(camera.camera, point.pixel), static_cast<int>(beam), point.depth_m});
  }
  replay_self_tests(table, camera.name);
  return table;
}

void replay_self_tests(const SensorTable& table, const std::string& where) {
  constexpr double kRounding = 1e-9;  // of the lens model's own inverse, and of depths [1/m]
  for (const SelfTest& test : table.self_tests) {
    const Eigen::Vector3d ray = table.rays.at(test.pixel).direction;
    const BeamGeometry beam = beam_geometry(table.beams[test.beam]);
    const double depth_m = beam_point(beam, ray).x.z();
    const double tolerance = kRounding + 2.0 * table.rays.error_rad / (beam.distance_m * std::abs(ray.z()));
    const bool holds = (ray - test.ray).norm() <= table.rays.error_rad + kRounding &&
                       std::abs(1.0 / depth_m - 1.0 / test.depth_m) <= tolerance;
    if (!holds) {
      throw Error(ErrorKind::kBadInput,
                  "the self-test fails: the table does not see its own dots where it should; "
                  "export it again with this program",
                  where);
    }
  }
}

}  // namespace raybundle
