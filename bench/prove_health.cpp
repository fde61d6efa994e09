// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// The watch over a calibration in use: how many frames it takes to report a projector that has turned by 0.05 px, by 0.06
// px about the line of sight, and how often it reports one that has not, while the laser warms and cools. Simulated are the labelled dots, not images:
// of 0.1 px, in rooms of random depth and slope, a tenth of them missing, with our own calibration and all its errors.
// A turn of so many pixels moves the dots of one metre by as much, root mean square; only the part across their curves
// is seen. Beside each turn stands the limit: how often ten frames suffice, by the noncentral chi-squared law, against
// the calibration, whose beams are uncertain, and against beams that are known. Prints what cannot be seen as well.
// usage: prove_health [frames without a turn, default 100000]
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <optional>

#include "raybundle/structured_light/health.hpp"
#include "raybundle/synthetic/random.hpp"
#include "sensor_worlds.hpp"

namespace {

using namespace raybundle;

constexpr double kNoise_px = 0.1;
constexpr int kWithin = 10;  // frames

struct Projector {
  std::vector<Line3> lines;  // true, in the camera's frame, aligned with the table's beams
  Eigen::Vector3d centre;
};

Projector projector_of(const bench::SensorInUse& sensor, double warmer_K, const Eigen::Vector3d& turn) {
  Projector projector;
  projector.centre = sensor.rig.emitter->rig_from_emitter.translation;
  const double angle = turn.norm();
  const Eigen::Matrix3d rotation =
      angle > 0.0 ? Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix() : Eigen::Matrix3d::Identity();
  const std::vector<EmittedBeam> beams = beams_of(warmer(*sensor.rig.emitter, warmer_K));
  for (const TableBeam& known : sensor.table.beams) {
    const auto beam = std::ranges::find_if(
        beams, [&](const EmittedBeam& b) { return b.row == known.row && b.column == known.column; });
    projector.lines.push_back(
        {projector.centre + rotation * (beam->line.point - projector.centre), rotation * beam->line.direction});
  }
  return projector;
}

// Labelled dots on a wall that is somewhere else in every frame, a tenth of them missing.
void see(const bench::SensorInUse& sensor, const Projector& projector, Random& random,
         std::vector<Health::Sample>& samples) {
  samples.clear();
  const double depth = random.uniform(0.4, 1.2), tilt_u = random.uniform(-0.5, 0.5), tilt_v = random.uniform(-0.5, 0.5);
  for (std::size_t b = 0; b < projector.lines.size(); ++b) {
    if (!sensor.table.beams[b].measured || random.chance(0.1)) continue;
    const Line3& line = projector.lines[b];
    const Eigen::Vector3d normal = Eigen::Vector3d(tilt_u, tilt_v, -1.0).normalized();
    const double at = (normal.z() * depth - normal.dot(line.point)) / normal.dot(line.direction);
    const Eigen::Vector3d x = line.at(at);
    if (x.z() < sensor.table.range.nearest_m || x.z() > sensor.table.range.farthest_m) continue;
    const auto exact = pixel_from_ray(sensor.camera.camera, x);
    if (!exact) continue;
    const double u = random.normal(), v = random.normal();
    const Eigen::Vector2d pixel = *exact + kNoise_px * Eigen::Vector2d(u, v);
    const ImageSize& size = sensor.table.rays.size;
    if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() > size.width - 1 || pixel.y() > size.height - 1) continue;
    samples.push_back(
        {static_cast<int>(b), sensor.table.rays.at(pixel), kNoise_px * kNoise_px * Eigen::Matrix2d::Identity()});
  }
}

// As the runtime does it: the beams follow the wavelength.
const HealthReport& update(Health& health, BeamSet& beams, const std::vector<Health::Sample>& samples) {
  const HealthReport& report = health.update(samples);
  if (report.state == State::kOk) beams.set_log_wavelength(report.log_wavelength);
  return report;
}

// Root mean square of the way [px] that the dots of one metre make by a turn of a radian, to first order.
double px_per_rad(const bench::SensorInUse& sensor, const Eigen::Vector3d& axis) {
  constexpr double kStep = 1e-4;
  const Projector from = projector_of(sensor, 0.0, {0, 0, 0}), to = projector_of(sensor, 0.0, kStep * axis);
  double squares = 0.0, count = 0.0;
  for (std::size_t b = 0; b < from.lines.size(); ++b) {
    const auto place = [&](const Line3& line) {
      return pixel_from_ray(sensor.camera.camera, line.at((1.0 - line.point.z()) / line.direction.z()));
    };
    const auto a = place(from.lines[b]), c = place(to.lines[b]);
    if (!a || !c) continue;
    squares += (*c - *a).squaredNorm() / (kStep * kStep);
    count += 1.0;
  }
  return std::sqrt(squares / count);
}

// Frames after a turn until it is reported; none when it is not within so many.
std::optional<int> frames_to_alarm(const bench::SensorInUse& sensor, const Projector& before, const Projector& after,
                                   int most, std::uint64_t seed) {
  BeamSet beams(sensor.table);
  Health health(beams, {});
  Random random(seed);
  std::vector<Health::Sample> samples;
  for (int frame = 0; frame < 60; ++frame) {
    see(sensor, before, random, samples);
    if (update(health, beams, samples).state == State::kInvalid) return 0;
  }
  for (int frame = 1; frame <= most; ++frame) {
    see(sensor, after, random, samples);
    if (update(health, beams, samples).state == State::kInvalid) return frame;
  }
  return std::nullopt;
}

// How likely the chi-squared law of three degrees of freedom, shifted by this much, is above a threshold.
double power(double noncentrality, double threshold) {
  const double m = std::sqrt(noncentrality), r = std::sqrt(threshold);
  const auto density = [](double x) { return std::exp(-0.5 * x * x) / std::sqrt(2.0 * M_PI); };
  const auto above = [](double x) { return 0.5 * std::erfc(x / std::sqrt(2.0)); };
  return above(r - m) + above(r + m) + (density(r - m) - density(r + m)) / m;
}

struct Limit {
  double across_px = 0.0;                             // of the turn, root mean square
  double by_calibration = 0.0, by_known_beams = 0.0;  // how likely ten frames suffice
};

// Of any watch, by the information in the dots: what wavelength does not explain.
Limit limit_of(const bench::SensorInUse& sensor, const Eigen::Vector3d& turn, double threshold) {
  constexpr int kScenes = 50;
  const BeamSet set(sensor.table);
  const Projector projector = projector_of(sensor, 0.0, {0, 0, 0});
  Random random(11);
  std::vector<Health::Sample> samples;
  // Of calibrated and of known beams: of the turn, of the wavelength, of both.
  std::array<double, 2> turns{}, waves{}, mixed{};
  waves.fill(std::pow(HealthOptions{}.wavelength_sigma, -2.0));
  double squares_px = 0.0, count = 0.0;
  for (int scene = 0; scene < kScenes; ++scene) {
    see(sensor, projector, random, samples);
    for (const Health::Sample& sample : samples) {
      const BeamGeometry& beam = set.beams[sample.beam];
      const BeamPoint point = beam_point(beam, sample.ray.direction);
      const double per_px2 = (sample.ray.per_px.transpose() * beam.normal).squaredNorm();
      const double by_turn = (point.x - projector.centre).cross(beam.normal).dot(turn) * point.inverse_distance;
      const double by_wave = beam.off_plane_by_wavelength(point.along_m, point.inverse_distance);
      const double of_beam = beam.off_plane_variance(point.along_m, point.inverse_distance);
      for (const int known : {0, 1}) {
        const double weight = 1.0 / (kNoise_px * kNoise_px * per_px2 / kWithin + (known ? 0.0 : of_beam)) / kScenes;
        turns[known] += weight * by_turn * by_turn;
        waves[known] += weight * by_wave * by_wave;
        mixed[known] += weight * by_turn * by_wave;
      }
      squares_px += by_turn * by_turn / per_px2;
      count += 1.0;
    }
  }
  const auto suffices = [&](int known) {
    return power(turns[known] - mixed[known] * mixed[known] / waves[known], threshold);
  };
  return {std::sqrt(squares_px / count), suffices(0), suffices(1)};
}

// The slowest of some draws; prints it.
bool prove_turn(const bench::SensorInUse& sensor, const char* what, const Eigen::Vector3d& axis, double turn_px,
                double warmer_K, bool barred) {
  const Projector before = projector_of(sensor, warmer_K, {0, 0, 0});
  const Eigen::Vector3d turn = turn_px / px_per_rad(sensor, axis) * axis;
  const Projector after = projector_of(sensor, warmer_K, turn);
  int slowest = 0, missed = 0, early = 0;
  constexpr int kDraws = 100;
  for (int draw = 0; draw < kDraws; ++draw) {
    const auto frames = frames_to_alarm(sensor, before, after, kWithin, 100 + draw);
    missed += !frames;
    early += frames && *frames == 0;
    slowest = std::max(slowest, frames.value_or(0));
  }
  const bool holds = missed == 0 && early == 0;
  const BeamSet beams(sensor.table);
  const Limit limit = limit_of(sensor, turn, Health(beams, {}).report().threshold);
  std::printf("  %.2f px %s (%.3f px across the curves), laser %+.0f K: ", turn_px, what, limit.across_px, warmer_K);
  if (missed > 0) std::printf("not reported in %d of %d draws", missed, kDraws);
  if (missed == 0) std::printf("reported within %d frames in all %d draws", slowest, kDraws);
  if (early > 0) std::printf(", %d of them before the turn", early);
  if (barred) std::printf(", bar %d frames  %s", kWithin, holds ? "pass" : "FAIL");
  std::printf("; limit: %.1f %% by the calibration, %.1f %% by known beams\n", 100.0 * limit.by_calibration,
              100.0 * limit.by_known_beams);
  return holds || !barred;
}

bool prove_quiet(const bench::SensorInUse& sensor, int frames) {
  BeamSet beams(sensor.table);
  Random random(5);
  std::vector<Health::Sample> samples;
  std::vector<Projector> warm;
  for (int kelvin = -10; kelvin <= 20; ++kelvin) warm.push_back(projector_of(sensor, kelvin, {0, 0, 0}));
  std::optional<Health> health(std::in_place, beams, HealthOptions{});
  int alarms = 0, temperature = 10;
  double largest = 0.0, worst_wavelength = 0.0;
  for (int frame = 0; frame < frames; ++frame) {
    if (frame % 200 == 199) {
      temperature = std::clamp(temperature + (random.chance(0.5) ? 1 : -1), 0, static_cast<int>(warm.size()) - 1);
    }
    see(sensor, warm[temperature], random, samples);
    const HealthReport& report = update(*health, beams, samples);
    largest = std::max({largest, report.chi_squared, report.recent_chi_squared});
    const double drift =
        (temperature - 10) * sensor.rig.emitter->wavelength_drift_m_K / sensor.rig.emitter->wavelength_m;
    if (frame % 200 > 20) worst_wavelength = std::max(worst_wavelength, std::abs(report.log_wavelength - drift));
    if (report.state != State::kInvalid) continue;
    ++alarms;
    health.emplace(beams, HealthOptions{});
  }
  std::printf(
      "  nothing but heat, %d frames: %d alarms, bar 0  %s; largest chi-squared %.1f, alarm above %.1f; "
      "wavelength within %.3f %% of the truth (10 K move it by 0.34 %%)\n",
      frames, alarms, alarms == 0 ? "pass" : "FAIL", largest, health->report().threshold, 100.0 * worst_wavelength);
  return alarms == 0;
}

}  // namespace

int main(int argc, char** argv) {
  const int frames = argc > 1 ? std::max(100, std::atoi(argv[1])) : 100000;
  bool passed = true;
  for (const LaserGrid grid : {LaserGrid{11, 11}, LaserGrid{16, 19}}) {
    const bench::SensorInUse sensor = bench::calibrated_sensor(grid, 12.0, {.tolerance_px = 1.0});
    std::printf("%dx%d, %zu beams; stated rate of false alarms: %g for each frame\n", grid.columns, grid.rows,
                sensor.table.beams.size(), HealthOptions{}.false_alarm_rate);
    for (const double warmer_K : {0.0, 10.0}) {
      passed &= prove_turn(sensor, "about the baseline", Eigen::Vector3d::UnitX(), 0.05, warmer_K, true);
      passed &= prove_turn(sensor, "about the line of sight", Eigen::Vector3d::UnitZ(), 0.06, warmer_K, true);
    }
    passed &= prove_quiet(sensor, frames);
    std::printf("  what it hardly sees: dots that move along their curves\n");
    for (const double turn_px : {0.05, 0.2, 1.0}) {
      prove_turn(sensor, "across both", Eigen::Vector3d::UnitY(), turn_px, 0.0, false);
    }
    std::fflush(stdout);
  }
  return passed ? EXIT_SUCCESS : EXIT_FAILURE;
}
