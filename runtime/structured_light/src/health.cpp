// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/structured_light/health.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace raybundle {
namespace {

constexpr double kClip_sigmas = 3.0;  // residuals count up to here: a wrong label must not raise an alarm

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

// The place nearest to all beams.
Eigen::Vector3d common_point(const BeamSet& set) {
  Eigen::Matrix3d normal = 1e-9 * Eigen::Matrix3d::Identity();  // one beam has no such place
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const BeamGeometry& beam : set.beams) {
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - beam.direction * beam.direction.transpose();
    normal += across;
    right += across * beam.point;
  }
  return normal.ldlt().solve(right);
}

}  // namespace

Health::Health(const BeamSet& beams, const HealthOptions& options)
    : beams_(beams), options_(options), centre_(common_point(beams)), frames_(options.window) {
  report_.threshold = chi_squared_threshold(options.false_alarm_rate);
}

Health::Frame Health::frame_of(std::span<const Sample> samples) const {
  Frame frame;
  for (const Sample& sample : samples) {
    const BeamGeometry& beam = beams_.beams[sample.beam];
    const BeamPoint point = beam_point(beam, sample.ray.direction);
    const Eigen::Vector2d gradient = sample.ray.per_px.transpose() * beam.normal;
    const double of_dot = gradient.dot(sample.covariance_px2 * gradient);
    const double of_beam = beam.off_plane_variance(point.along_m, point.inverse_distance);
    // Over the window the dots' noise averages out, the beams' errors stay.
    const double weight = 1.0 / (of_dot / static_cast<double>(frames_.size()) + of_beam);
    const double clip = kClip_sigmas * std::sqrt(of_dot + of_beam);
    const double off = std::clamp(beam.off_plane(sample.ray.direction), -clip, clip);
    Vector4 by;
    by << beam.off_plane_by_wavelength(point.along_m, point.inverse_distance),
        (point.x - centre_).cross(beam.normal) * point.inverse_distance;
    const Matrix4 square = by * by.transpose();
    frame.normal += weight * square;
    frame.by_dots += weight * weight * of_dot * square;
    frame.by_beams += weight * weight * of_beam * square;
    // Beams that have been moved to another wavelength leave the rest only.
    frame.right += weight * (off + by[0] * beams_.log_wavelength) * by;
    frame.squares += off * off / (of_dot + of_beam);
    ++frame.dots;
  }
  return frame;
}

void Health::judge() {
  Frame sum;
  for (const Frame& frame : frames_) {
    sum.normal += frame.normal;
    sum.by_dots += frame.by_dots;
    sum.by_beams += frame.by_beams;
    sum.right += frame.right;
    sum.squares += frame.squares;
    sum.dots += frame.dots;
  }
  report_.dots = sum.dots;
  if (sum.dots < options_.least_dots) {
    if (report_.state != State::kInvalid) report_.state = State::kDegraded;
    return;
  }
  sum.normal(0, 0) += 1.0 / (options_.wavelength_sigma * options_.wavelength_sigma);
  sum.normal.diagonal().tail<3>().array() += 1.0;  // a turn of less than a radian: keeps one unseen axis finite
  const Matrix4 inverse = sum.normal.inverse();
  const Vector4 change = inverse * sum.right;
  // The beams' errors are the same in each frame: over the window they add up, not their squares.
  const double frames = static_cast<double>(frames_.size());
  report_.noise = std::sqrt(sum.squares / sum.dots);
  const double inflation = std::max(1.0, report_.noise * report_.noise);
  Matrix4 covariance = inverse * (inflation * sum.by_dots + frames * sum.by_beams) * inverse;
  covariance(0, 0) += 1e-20;
  const Eigen::Matrix3d of_turn = covariance.bottomRightCorner<3, 3>();
  report_.log_wavelength = change[0];
  report_.log_wavelength_sigma = std::sqrt(covariance(0, 0));
  report_.turn_rad = change.tail<3>();
  report_.turn_sigma_rad = of_turn.diagonal().cwiseSqrt();
  report_.statistic = report_.turn_rad.dot(of_turn.ldlt().solve(report_.turn_rad));
  const bool alarm = report_.statistic > report_.threshold;
  if (alarm) report_.state = State::kInvalid;
  if (!alarm && report_.state != State::kInvalid) report_.state = State::kOk;
}

const HealthReport& Health::update(std::span<const Sample> samples) {
  frames_[next_] = frame_of(samples);
  next_ = (next_ + 1) % frames_.size();
  judge();
  return report_;
}

}  // namespace raybundle
