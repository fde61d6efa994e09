// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
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
  double brightness = 0.0;  ///< grey values above the background, summed as its finder weights them; 0: not measured
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

/// Depths at which a calibration states how well a dot's depth is known [m].
inline constexpr std::array kStatedDepths_m{0.3, 0.5, 1.0, 1.5};

/// How well a dot's depth, along z of the rig's first camera, is known where camera and beam meet.
struct BeamDepth {
  double sigma_m = std::numeric_limits<double>::quiet_NaN();  ///< of the calibration; NaN: the camera does not see it
  double per_px_m =
      std::numeric_limits<double>::quiet_NaN();  ///< of a dot that is off by a pixel along its epipolar line
};

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
  std::array<BeamDepth, kStatedDepths_m.size()> depths = {};  ///< at kStatedDepths_m
};

/// Two beams whose dots can lie at the same place of the image, so that one dot alone does not tell them apart.
struct AmbiguousBeams {
  int first = 0;  ///< LaserGrid::index; first < second
  int second = 0;
  double distance_px = 0.0;  ///< between their curves in the image, at the closest
};

/// How well single dots tell the beams of a pattern apart in one camera's image.
struct BeamAmbiguity {
  double tolerance_px = 0.0;            ///< distance up to which a dot may belong to a beam's curve
  std::vector<AmbiguousBeams> pairs;    ///< sorted; those within the tolerance somewhere
  double single_candidate_share = 1.0;  ///< of the dots, over beams and inverse depths: only one beam is in question
};

/// A turn of the lattice about its own axis and the ambiguity that it would have.
struct TurnedPattern {
  double turn_rad = 0.0;  ///< from how the pattern is now, in (-45°, 45°]
  double single_candidate_share = 0.0;
};

/// What is to be known before dots are labelled at runtime, in the image of the rig's first camera.
struct LabelAdvice {
  BeamAmbiguity ambiguity;  ///< at the advised tolerance
  std::optional<TurnedPattern> best_turn;
};

/// All calibrated beams of a projector. A beam that nothing determined is not in the list.
struct LaserPattern {
  LaserGrid grid;
  std::vector<LaserBeam> beams;    ///< sorted by row, then column
  std::optional<Grating> grating;  ///< the common model, where the beams follow one
  double zero_order_row = 0.0;     ///< row and column of order (0, 0): orders are m = column - zero_order_column, ...
  double zero_order_column = 0.0;
  std::optional<LabelAdvice> advice = {};
};

/// The line that the pattern's grating gives the beam in this row and column, in the rig frame; nullopt without a grating
/// and where the order does not leave it.
std::optional<Line3> line_of_model(const LaserPattern& pattern, int row, int column);

/// The pattern when the laser's wavelength is this many times what it was during calibration, as temperature moves it
/// (about 0.28 nm/K for diodes). Each beam moves as its order of the grating's model does and keeps how it differs from
/// the model; what is derived from the beams (depths, advice) stays as it was. Needs a grating.
LaserPattern at_wavelength(const LaserPattern& pattern, double scale);

}  // namespace raybundle
