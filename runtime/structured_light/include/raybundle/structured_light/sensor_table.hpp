// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "raybundle/geometry/line.hpp"
#include "raybundle/scene/calibration.hpp"
#include "raybundle/structured_light/ray_table.hpp"

namespace raybundle {

/// Where a sensor measures, and how closely a dot has to lie to its beam's curve.
struct SensorRange {
  double nearest_m = 0.15;  ///< depth, along z of the camera
  double farthest_m = 1.5;
  double tolerance_px = 1.0;

  /// Depth from which dots are explained [m]: what comes too near is told from what is measured, not taken for it.
  double explained_from_m() const { return 0.5 * nearest_m; }
};

/// A beam as the device knows it. Its covariance is that of the motion of perturbed(line, .), with what all beams share
/// of it. Beams that the calibration did not determine are foreseen by the grating's model: they explain dots, so that no
/// other beam does, and measure nothing.
struct TableBeam {
  int row = 0;
  int column = 0;
  bool measured = true;
  Line3 line;  ///< in the camera's frame, away from the projector
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  Eigen::Vector4d per_wavelength = Eigen::Vector4d::Zero();  ///< motion for each unit of ln(wavelength); 0: not known
};

/// Beams of a grid that a table holds at most: its lists count them in 16 bits.
inline constexpr int kMostBeams = 1 << 14;

/// Sigma of ln(wavelength) over that of the calibration while nothing is seen: 15 K of a laser diode.
inline constexpr double kLogWavelengthSigma = 0.005;

/// Within so many it is looked for, 60 K: calibrated in a room, started on a hot or an icy day.
inline constexpr int kWavelengthSigmas = 4;

/// The beams that can be seen in a square cell of the image: from the depth on that is explained, within tolerance and
/// drift, by a laser within kWavelengthSigmas.
struct CandidateLists {
  int cell_px = 16;
  int columns = 0;  ///< of cells
  int rows = 0;
  std::vector<std::uint32_t> first;  ///< of each cell, in `beams`; one more than there are cells
  std::vector<std::uint16_t> beams;  ///< indices into SensorTable::beams, ascending in a cell

  std::span<const std::uint16_t> at(const Eigen::Vector2d& pixel) const;
};

/// A dot that the device has to see as the calibration did.
struct SelfTest {
  Eigen::Vector2d pixel;
  Eigen::Vector3d ray;   ///< by the lens model
  int beam = 0;          ///< index into SensorTable::beams
  double depth_m = 0.0;  ///< of the beam's point that is seen at the pixel, along z of the camera
};

/// All that a device knows of its sensor: one camera, the beams beside it, where they may be seen.
struct SensorTable {
  std::string camera;  ///< its name in the calibration
  std::string origin;  ///< what the table was made of, for people
  SensorRange range;
  double drift_px = 2.0;  ///< by which curves may move, besides with wavelength, before the candidate lists miss some
  RayTable rays;
  LaserGrid grid;
  /// Of a motion that all beams share, rotation [rad] about the camera's centre and translation [m]: the camera's place
  /// on the rig may be off. Zero for the first camera, in whose frame the beams were calibrated.
  Eigen::Matrix<double, 6, 6> shared_covariance = Eigen::Matrix<double, 6, 6>::Zero();
  std::vector<TableBeam> beams;  ///< sorted by row, then column
  CandidateLists candidates;
  std::vector<SelfTest> self_tests;
  std::string serial;  ///< of the file; empty before it is written
};

/// @param camera  of the calibration; the first one when empty
/// @throws Error(kBadInput) for a calibration without beams or with too many, an unknown camera or a senseless range;
///         Error(kNotEnoughData) when the camera sees no beam within the range
SensorTable sensor_table(const Calibration& calibration, const std::string& camera, const SensorRange& range,
                         const std::string& origin);

/// Throws Error(kBadInput) when rays or depths of the self-test do not come out again.
void replay_self_tests(const SensorTable& table, const std::string& where);

}  // namespace raybundle
