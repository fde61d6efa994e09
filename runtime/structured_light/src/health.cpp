// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/structured_light/health.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

constexpr double kClipSigmas = 3.0;  // residuals count up to here: a wrong label must not raise an alarm

// Share of the chi-squared law of three degrees of freedom above a value.
double chi_squared_above(double value) {
  return std::erfc(std::sqrt(0.5 * value)) + std::sqrt(2.0 * value / M_PI) * std::exp(-0.5 * value);
}

double chi_squared_threshold(double share) {
  double low = 0.0, high = 1000.0;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (chi_squared_above(middle) > share ? low : high) = middle;
  }
  return high;
}

Eigen::Vector3d source_of(const SensorTable& table) {
  std::vector<Line3> lines;
  for (const TableBeam& beam : table.beams) lines.push_back(beam.line);
  return point_nearest_to(lines);
}

// How a beam's offset and slope along the normal of its epipolar plane change with a motion that all beams share:
// rotation about the camera's centre, translation.
Eigen::Matrix<double, 2, 6> by_shared_motion(const BeamGeometry& beam) {
  Eigen::Matrix<double, 2, 6> by;
  by << beam.point.cross(beam.normal).transpose(), beam.normal.transpose(),  //
      beam.direction.cross(beam.normal).transpose(), Eigen::RowVector3d::Zero();
  return by;
}

const HealthOptions& checked(const HealthOptions& options) {
  if (options.window >= 1 && options.memory >= 1) return options;
  throw Error(ErrorKind::kBadInput, "the watch over a calibration takes a window and a memory of 1 frame or more");
}

}  // namespace

Health::Health(const BeamSet& beams, const HealthOptions& options)
    : beams_(beams),
      options_(checked(options)),
      centre_(source_of(beams.table)),
      memory_(beams, options.memory),
      frames_(options.window) {
  report_.threshold = chi_squared_threshold(0.5 * options.false_alarm_rate);  // of two tests
  for (Frame& frame : frames_) frame.seen.reserve(beams.beams.size());
}

void Health::Sums::add(const Vector4& by, double off, double of_dot, double of_beam, const RowVector6& off_by_motion,
                       double frames) {
  // Over the window the dots' noise averages out, the beams' errors stay.
  const double weight = 1.0 / (of_dot / frames + of_beam);
  const Matrix4 square = by * by.transpose();
  normal += weight * square;
  by_dots += weight * weight * of_dot * square;
  by_beams += weight * weight * of_beam * square;
  right += weight * off * by;
  by_motion += weight * by * off_by_motion;
}

Health::Sums& Health::Sums::operator+=(const Sums& other) {
  normal += other.normal;
  by_dots += other.by_dots;
  by_beams += other.by_beams;
  right += other.right;
  by_motion += other.by_motion;
  squares += other.squares;
  return *this;
}

void Health::take(std::span<const Sample> samples, Frame& frame) const {
  const double frames = static_cast<double>(frames_.size());
  frame.by_calibration = frame.by_memory = {};
  frame.seen.clear();
  for (const Sample& sample : samples) {
    const BeamGeometry& beam = beams_.beams[sample.beam];
    const BeamPoint point = beam_point(beam, sample.ray.direction);
    const Eigen::Vector2d gradient = sample.ray.per_px.transpose() * beam.normal;
    const double of_dot = gradient.dot(sample.covariance_px2 * gradient);
    const double of_beam = beam.off_plane_variance(point.along_m, point.inverse_distance);
    Vector4 by;
    by << beam.off_plane_by_wavelength(point.along_m, point.inverse_distance),
        (point.x - centre_).cross(beam.normal) * point.inverse_distance;
    const double of_wavelength = by[0] * by[0] * beams_.log_wavelength_variance;
    const double clip = kClipSigmas * std::sqrt(of_dot + of_beam + of_wavelength);
    const double off = std::clamp(beam.off_plane(sample.ray.direction), -clip, clip);
    // Beams that have been moved to another wavelength leave the rest only.
    const double off_calibrated = off + by[0] * beams_.log_wavelength;
    const BeamMemory::Off known = memory_.off(sample.beam, point.along_m, point.inverse_distance);
    const Eigen::Matrix<double, 2, 6> by_motion = by_shared_motion(beam);
    const Eigen::RowVector2d at(point.inverse_distance, point.along_m * point.inverse_distance);
    frame.by_calibration.add(by, off_calibrated, of_dot, of_beam, at * by_motion, frames);
    frame.by_calibration.squares += off * off / (of_dot + of_beam + of_wavelength);
    frame.by_memory.add(by, off_calibrated - known.mean, of_dot, known.variance, known.by_calibration * by_motion,
                        frames);
    frame.by_memory.squares += std::pow(off - known.mean, 2) / (of_dot + known.variance + of_wavelength);
    frame.seen.push_back({sample.beam, point.along_m, point.inverse_distance, off_calibrated, by[0], of_dot});
  }
}

// What leaves the window without an alarm is how the beams are.
void Health::learn(const Frame& frame) {
  memory_.fade();
  for (const Seen& seen : frame.seen) {
    const double off = seen.off - seen.by_wavelength * report_.log_wavelength;
    memory_.learn(seen.beam, seen.along_m, seen.inverse_distance, off, seen.variance);
  }
}

Health::Solution Health::solve(Sums sum, int dots) const {
  Vector4 before;  // information before anything is seen; a turn of less than a radian keeps one unseen axis finite
  before << 1.0 / (options_.wavelength_sigma * options_.wavelength_sigma), 1.0, 1.0, 1.0;
  sum.normal.diagonal() += before;
  const Matrix4 inverse = sum.normal.inverse();
  Solution solution;
  solution.change = inverse * sum.right;
  solution.residual_scale = std::sqrt(sum.squares / dots);
  // The beams' errors are the same in each frame: over the window they add up, not their squares.
  const double frames = static_cast<double>(frames_.size());
  const double inflation = std::max(1.0, solution.residual_scale * solution.residual_scale);
  Matrix4 of_right = inflation * sum.by_dots + frames * sum.by_beams;
  of_right += sum.by_motion * beams_.table.shared_covariance * sum.by_motion.transpose();
  of_right.diagonal() += before;
  solution.covariance = inverse * of_right * inverse;
  const Eigen::Vector3d turn = solution.change.tail<3>();
  const Eigen::Matrix3d of_turn = solution.covariance.bottomRightCorner<3, 3>();
  solution.chi_squared = turn.dot(of_turn.ldlt().solve(turn));
  return solution;
}

void Health::judge() {
  Sums by_calibration, by_memory;
  report_.dots = 0;
  for (const Frame& frame : frames_) {
    by_calibration += frame.by_calibration;
    by_memory += frame.by_memory;
    report_.dots += static_cast<int>(frame.seen.size());
  }
  if (report_.dots < options_.least_dots) {
    if (report_.state != State::kInvalid) report_.state = State::kDegraded;
    return;
  }
  const Solution solution = solve(by_calibration, report_.dots), recent = solve(by_memory, report_.dots);
  report_.log_wavelength = solution.change[0];
  report_.log_wavelength_sigma = std::sqrt(solution.covariance(0, 0));
  report_.turn_rad = solution.change.tail<3>();
  report_.turn_sigma_rad = solution.covariance.diagonal().tail<3>().cwiseSqrt();
  report_.chi_squared = solution.chi_squared;
  report_.residual_scale = solution.residual_scale;
  report_.recent_turn_rad = recent.change.tail<3>();
  report_.recent_chi_squared = recent.chi_squared;
  const bool alarm = std::max(solution.chi_squared, recent.chi_squared) > report_.threshold;
  if (alarm) report_.state = State::kInvalid;
  if (!alarm && report_.state != State::kInvalid) report_.state = State::kOk;
}

const HealthReport& Health::update(std::span<const Sample> samples) {
  Frame& oldest = frames_[next_];
  if (report_.state == State::kOk) learn(oldest);
  take(samples, oldest);
  next_ = (next_ + 1) % frames_.size();
  judge();
  return report_;
}

}  // namespace raybundle
