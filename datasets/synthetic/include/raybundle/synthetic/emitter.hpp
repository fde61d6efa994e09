// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <utility>
#include <vector>

#include "raybundle/geometry/line.hpp"
#include "raybundle/geometry/rigid3.hpp"
#include "raybundle/scene/laser.hpp"

namespace raybundle {

/// A plano-concave lens in front of a grating, its axis along the grating's z.
struct SpreadingLens {
  double radius_m = 0.0;                               ///< of the concave side; focal length = -radius / (index - 1)
  double index = 1.5;                                  ///< of the glass at the laser's wavelength
  double distance_m = 0.0;                             ///< from the grating to the lens on its axis
  double thickness_m = 1e-3;                           ///< on its axis
  bool concave_inside = true;                          ///< the concave side faces the grating; else the scene
  Eigen::Vector2d offset_m = Eigen::Vector2d::Zero();  ///< of the lens's axis from the laser: no mount is perfect
};

/// A laser diode, a Dammann grating that splits its beam into orders, and a lens that spreads them. It is traced by
/// Snell's law, so that the beams share no apex: an independent truth for the closed form of Grating.
///
/// Order (m, n) leaves the grating, at the origin, with direction cosines wavelength (m / column_period, n /
/// row_period), turned by lattice_turn [grating equation, normal incidence]; m = column - zero_order_column, n = row -
/// zero_order_row.
struct Emitter {
  LaserGrid grid;
  double wavelength_m = 830e-9;
  double column_period_m = 0.0;   ///< of the grating, along its x
  double row_period_m = 0.0;      ///< of the grating, along its y
  double lattice_turn_rad = 0.0;  ///< of the grating about z, against the emitter's x and y
  double zero_order_row = 0.0;    ///< half a row where the grating has an even number of orders
  double zero_order_column = 0.0;
  double zero_order_power = 1.0;             ///< over that of another beam
  std::vector<std::pair<int, int>> missing;  ///< row, column of beams that the grating does not make
  std::optional<SpreadingLens> lens;
  Rigid3 rig_from_emitter;                ///< origin on the grating, z along the laser
  double beam_power_W = 60e-6;            ///< of each beam but order zero
  double spot_radius_m = 2e-3;            ///< 1/e² radius of a beam at its waist
  double waist_distance_m = 0.6;          ///< from the emitter
  double divergence_rad = 1.5e-3;         ///< half-angle far from the waist
  double speckle_contrast = 0.0;          ///< standard deviation over mean of the spot's light in a pixel
  double wavelength_drift_m_K = 0.28e-9;  ///< change of the wavelength with temperature
};

/// A beam that the emitter makes.
struct EmittedBeam {
  int row = -1;  ///< -1: a zero order that belongs to no row and column
  int column = -1;
  Line3 line;  ///< in the rig frame; its point lies where it leaves the lens, or the grating
  double power_W = 0.0;

  bool labelled() const { return row >= 0; }
};

/// The ray of an order behind the lens, in the emitter's frame; nullopt where the order does not exist, misses the lens
/// or is totally reflected in it.
///
/// @param m, n  orders along x and y
std::optional<Line3> ray_of_order(const Emitter& emitter, double m, double n);

/// All beams, row by row, a zero order that is not in the grid last.
///
/// @throws Error(kBadInput) naming the first beam that does not leave the lens
std::vector<EmittedBeam> beams_of(const Emitter& emitter);

/// Makes it an emitter of other counts that fills the same field. Its zero order is in the middle; where that is
/// between the beams, the grating suppresses it. No beam is missing.
///
/// @throws Error(kBadInput) when either has less than two rows or columns
void set_grid(Emitter& emitter, const LaserGrid& grid);

/// Sets the periods so that the outermost beams of the middle column and row have this angle between them.
///
/// @param field_rad  between the outermost columns and rows, full angles
/// @throws Error(kBadInput) when the lens cannot spread them so far
void set_periods_from_field(Emitter& emitter, const Eigen::Vector2d& field_rad);

/// The emitter when it is warmer than at its wavelength by so much.
Emitter warmer(const Emitter& emitter, double kelvin);

}  // namespace raybundle
