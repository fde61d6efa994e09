// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/occupancy/scan.hpp"
#include "raybundle/occupancy/seat.hpp"
#include "raybundle/occupancy/vehicle.hpp"

namespace raybundle {

struct SeatFitOptions {
  double half_width_m = 0.11;  ///< of the seat's flat middle: bolsters rise beside it
  double tolerance_m = 0.03;   ///< of a point from a line that it belongs to, with two of its sigmas; wider at first
  int least_points = 12;       ///< on each line
  int iterations = 12;
  double alike_points = 16.0;  ///< so many points err alike, as neighbouring pixels of a matcher do: for sigmas
  double occupied_m = 0.06;    ///< what is so far before both lines is on the seat
  double most_hidden = 0.15;   ///< share of the points within the seat's reach that may be on it: more hide the seat
};

/// A seat that was found.
struct SeatFit {
  SeatPose pose;
  bool found = false;  ///< both lines were seen, and their setting is one that the car allows
  int cushion_points = 0;
  int back_points = 0;
  Eigen::Vector2d bight_sigma_m = Eigen::Vector2d::Zero();  ///< by the points' scatter about the lines
  double recline_sigma_rad = 0.0;
  double hidden = 0.0;  ///< share of the points within the seat's reach that are on it
};

/// Cushion and back as two lines in the longitudinal plane. They start from the seat amid its travel and grow: points
/// near a line join it, the line is fitted again, and what would leave the travel that the car allows is refused. Of
/// points before the seat, those of an occupant, none joins; a seat that is hidden is not found.
SeatFit fit_seat(const VehicleLayout& layout, const Scan& scan, const SeatFitOptions& options = {});

/// The seat over several frames, averaged: noise errs anew in each, and their scatter tells by how much. What the
/// seat's covers and their texture do to the points of one frame, they do to those of all: that part of the sigma
/// stays.
///
/// While somebody or something hides the seat, it stays as it was when it was last seen: its sigma does not know of a
/// seat that is moved with somebody on it, frames_since_seen() does.
class SeatWatch {
 public:
  /// Takes one more frame; fits that found nothing change nothing. A seat elsewhere than before was moved: what was
  /// before is forgotten.
  void add(const SeatFit& fit);

  /// Mean of the frames; sigmas are those of one frame and, from the third on, of the mean by the scatter between them.
  SeatFit seat() const;

  /// That of the seat; amid its travel as long as it was not seen.
  SeatPose pose() const { return frames_ > 0 ? seat().pose : SeatPose{}; }

  int frames() const { return frames_; }
  int frames_since_seen() const { return since_seen_; }  ///< that were added since the seat was last found

 private:
  SeatFit last_;
  int frames_ = 0, since_seen_ = 0;
  Eigen::Vector4d mean_ = Eigen::Vector4d::Zero();      ///< bight x and z, recline, pitch
  Eigen::Vector4d squares_ = Eigen::Vector4d::Zero();   ///< of the deviations from it
  Eigen::Vector3d variance_ = Eigen::Vector3d::Zero();  ///< of one frame, by its points: bight x and z, recline
};

}  // namespace raybundle
