// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "raybundle/device/state.hpp"
#include "raybundle/structured_light/beam_memory.hpp"
#include "raybundle/structured_light/candidates.hpp"

namespace raybundle {

struct HealthOptions {
  int window = 10;   ///< frames that are judged together
  int memory = 300;  ///< frames over which the beams' own errors are learnt
  /// For each frame, by the chi-squared law of three degrees of freedom. An alarm stays until the next start, so that
  /// the life of a car counts: at twenty frames a second for 6000 hours, fewer than one in twenty sees a false one. At
  /// 1e-6 it would be one every 14 hours, for turns that are a fifth smaller.
  double false_alarm_rate = 1e-10;
  int least_dots = 30;                            ///< labelled, in the window: with fewer nothing is known
  double wavelength_sigma = kLogWavelengthSigma;  ///< of ln(wavelength), before anything is seen
};

/// What the labelled dots say about the calibration.
struct HealthReport {
  State state = State::kDegraded;  ///< kDegraded: too few dots to tell; kInvalid: the projector has turned
  double log_wavelength = 0.0;     ///< estimated, ln of the wavelength over that of the calibration
  double log_wavelength_sigma = 0.0;
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();         ///< of the projector about its centre, camera's axes
  Eigen::Vector3d turn_sigma_rad = Eigen::Vector3d::Zero();   ///< large about the axis that epipolar planes do not see
  double chi_squared = 0.0;                                   ///< of the turn, three degrees of freedom
  Eigen::Vector3d recent_turn_rad = Eigen::Vector3d::Zero();  ///< against the frames before the window
  double recent_chi_squared = 0.0;                            ///< of that
  double threshold = 0.0;                                     ///< of either, above which an alarm is raised
  double residual_scale = 1.0;                                ///< size of the residuals over what dots and beams state
  int dots = 0;                                               ///< in the window
};

/// Watches a calibration by the equation that triangulation leaves over: a dot lies on its beam's epipolar plane.
///
/// The distances of the labelled dots from their planes, over a window of frames, are explained by a change of the
/// wavelength and a turn of the projector, together, so that heat is not taken for a turn nor hides one. That is done
/// twice. Against the calibration: what it leaves uncertain of the beams does not average out over frames, and bounds
/// the turn that can be told; what all beams share of it, as the camera's place on the rig, does not average out over
/// beams either. Against what the frames before the window taught of each beam: that finds smaller turns,
/// if they happen while it runs; slower ones are learnt and left to the first. It cannot see what moves dots along
/// their curves: a turn about the axis at right angles to the baseline and to the line of sight, a change of the
/// baseline's length.
class Health {
 public:
  Health(const BeamSet& beams, const HealthOptions& options);

  /// A labelled dot.
  struct Sample {
    int beam = 0;
    RayTable::Ray ray;
    Eigen::Matrix2d covariance_px2;
  };

  /// Takes in a frame. `beams` must be those of the start; their wavelength may have been moved since.
  const HealthReport& update(std::span<const Sample> samples);

  const HealthReport& report() const { return report_; }

 private:
  using Vector4 = Eigen::Vector4d;  // ln(wavelength), turn
  using Matrix4 = Eigen::Matrix4d;
  using RowVector6 = Eigen::Matrix<double, 1, 6>;  // by the motion of SensorTable::shared_covariance

  /// Of the least-squares problem of some frames.
  struct Sums {
    Matrix4 normal = Matrix4::Zero();    // sum of w a aᵀ
    Matrix4 by_dots = Matrix4::Zero();   // covariance of `right` by the dots
    Matrix4 by_beams = Matrix4::Zero();  // by the beams: the same in every frame
    Vector4 right = Vector4::Zero();     // sum of w a e
    double squares = 0.0;                // of the residuals over their sigmas
    Eigen::Matrix<double, 4, 6> by_motion = Eigen::Matrix<double, 4, 6>::Zero();  // of `right`, that beams share

    void add(const Vector4& by, double off, double of_dot, double of_beam, const RowVector6& off_by_motion,
             double frames);
    Sums& operator+=(const Sums& other);
  };

  /// A dot as a distance from its plane.
  struct Seen {
    int beam = 0;
    double along_m = 0.0, inverse_distance = 0.0;
    double off = 0.0;  // of the plane at the calibration's wavelength
    double by_wavelength = 0.0;
    double variance = 0.0;  // by the dot
  };

  struct Frame {
    Sums by_calibration, by_memory;
    std::vector<Seen> seen;
  };

  struct Solution {
    Vector4 change;
    Matrix4 covariance;
    double residual_scale = 1.0, chi_squared = 0.0;
  };

  void take(std::span<const Sample> samples, Frame& frame) const;
  void learn(const Frame& frame);
  Solution solve(Sums sum, int dots) const;
  void judge();

  const BeamSet& beams_;
  HealthOptions options_;
  Eigen::Vector3d centre_;  ///< of the projector, in the camera's frame [m]
  BeamMemory memory_;
  std::vector<Frame> frames_;
  std::size_t next_ = 0;
  HealthReport report_;
};

}  // namespace raybundle
