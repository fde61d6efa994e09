// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "raybundle/geometry/line.hpp"
#include "raybundle/geometry/rigid3.hpp"

namespace raybundle {

/// Label of a dot of which it is not known which beam made it.
inline constexpr int kUnlabelled = -1;

/// Where a laser beam's spot on a board was measured in an image.
struct Dot {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();               ///< [px], (0, 0) is the centre of the top-left pixel
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Identity();  ///< positive definite
  int beam = kUnlabelled;                                        ///< LaserGrid::index, or kUnlabelled
  double brightness = 0.0;  ///< grey values above the background, summed over the spot; 0: not measured
};

/// How the beams of a projector are counted: row by row.
struct LaserGrid {
  int rows = 0;
  int columns = 0;

  int size() const { return rows * columns; }
  int index(int row, int column) const { return row * columns + column; }
  int row(int beam) const { return beam / columns; }
  int column(int beam) const { return beam % columns; }
};

/// What a diffraction grating behind a spreading lens does to one laser beam. Order (m, n) leaves the grating with
/// direction cosines linear in the orders; the lens then bends it away from the axis and moves the point that it seems
/// to come from, so that the beams share no apex:
///
///   c = wavelength_scale (m column_pitch (1, 0) + n row_pitch (sin skew, cos skew)),  s² = |c|²
///   direction ∝ (c (1 + k1 s² + k2 s⁴), sqrt(1 - |c (1 + k1 s² + k2 s⁴)|²)),  point = (0, 0, shift s²)
///
/// in the projector's frame, whose z is the zero order's axis. Sources: the grating equation (Goodman, Introduction to
/// Fourier Optics, 4.4); k1, k2 and shift are the first terms of the lens's aberration series.
struct Grating {
  Rigid3 rig_from_projector;
  double column_pitch = 0.0;  ///< direction cosine for each order m, wavelength / period
  double row_pitch = 0.0;     ///< direction cosine for each order n
  double skew_rad = 0.0;      ///< of the rows' step against the right angle to the columns' step
  double k1 = 0.0;
  double k2 = 0.0;
  double shift_m = 0.0;
  double wavelength_scale = 1.0;  ///< wavelength over the one during calibration: temperature moves it, nothing else
};

/// The beam of order (m, n), in the rig frame; nullopt where the order does not leave the grating (|c| >= 1).
std::optional<Line3> beam_of_order(const Grating& grating, double m, double n);

/// A calibrated beam. `covariance` is that of the motion of perturbed(line, .): two offsets [m], two slopes [rad];
/// `line.point` lies amid the places where the board met the beam, where offsets and slopes are least correlated.
struct LaserBeam {
  int row = 0;
  int column = 0;
  Line3 line;  ///< in the rig frame, directed away from the projector
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  int hits = 0;                ///< dots that determined it
  double nearest_hit_m = 0.0;  ///< range of the hits along the line, from the point nearest to the rig's origin
  double farthest_hit_m = 0.0;
};

/// All calibrated beams of a projector. A beam that nothing determined is not in the list.
struct LaserPattern {
  LaserGrid grid;
  std::vector<LaserBeam> beams;    ///< sorted by row, then column
  std::optional<Grating> grating;  ///< the common model, where the beams follow one
  double zero_order_row = 0.0;     ///< row and column of order (0, 0): orders are m = column - zero_order_column, ...
  double zero_order_column = 0.0;
};

}  // namespace raybundle
