// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "raybundle/geometry/rigid3.hpp"

namespace raybundle {

// Vehicle frame: x forward to the dashboard, y left, z up [m]. Its origin is the passenger's H-point with the seat
// amid its travel; left-hand drive, so that the middle of the car is at positive y.

/// Who or what is on the passenger seat.
enum class CabinClass : std::uint8_t {
  kEmpty,
  kPassenger,      ///< in a normal position
  kOutOfPosition,  ///< a passenger of whom something is in a safety zone
  kEmptyBooster,
  kChildInBooster,
  kForwardBabySeat,  ///< with or without a child
  kRearBabySeat,     ///< with or without a child
  kObjects,
};
inline constexpr int kCabinClasses = 8;
inline constexpr std::array<std::string_view, kCabinClasses> kCabinClassNames{
    "empty",          "passenger", "out_of_position", "empty_booster", "child_in_booster", "forward_baby_seat",
    "rear_baby_seat", "objects"};

/// The coarse classes.
enum class CabinGroup : std::uint8_t { kEmpty, kBabySeat, kSomething };
inline constexpr std::array<std::string_view, 3> kCabinGroupNames{"empty", "baby_seat", "something"};

/// What the airbag should do in a crash.
enum class CabinDecision : std::uint8_t { kFire, kDepowered, kNoFire };
inline constexpr std::array<std::string_view, 3> kCabinDecisionNames{"fire", "depowered", "no_fire"};

/// What whoever installs the sensor knows of the car. The safety zones are in front of the dashboard's vertical plane,
/// above the knees and as wide as the seat.
struct CabinLayout {
  double dashboard_x_m = 0.70;      ///< vertical plane through the dashboard's rearmost edge: distances count from here
  double dashboard_top_m = 0.46;    ///< z
  double zone_floor_m = 0.30;       ///< z; below are the knees of every passenger
  double zone_half_width_m = 0.32;  ///< |y|
  double critical_m = 0.20;         ///< depth of the critical out-of-position zone
  double out_of_position_m = 0.40;  ///< depth of both zones
  double track_m = 0.12;            ///< the seat moves so far to the front and back
  double lift_m = 0.03;             ///< and up and down
  double least_recline_rad = 12 * M_PI / 180;  ///< of the seat's back from the vertical
  double most_recline_rad = 40 * M_PI / 180;
  double roof_m = 1.02;                            ///< z
  double door_y_m = -0.42;                         ///< inner side of the passenger's door
  double middle_y_m = 0.38;                        ///< of the car
  std::vector<Eigen::AlignedBox3d> fixtures = {};  ///< parts of the car that stand in the zones
};

/// How the seat is set. The flat middle of cushion and back are two planes across the vehicle's longitudinal plane;
/// they meet in the bight.
struct SeatSetting {
  Eigen::Vector3d h_point = Eigen::Vector3d::Zero();  ///< [m] in the vehicle frame
  Eigen::Vector3d bight = Eigen::Vector3d::Zero();    ///< [m] where cushion and back meet, at y = 0
  double recline_rad = 0.0;                           ///< of the back's plane from the vertical, to the rear
  double cushion_pitch_rad = 0.0;                     ///< of the cushion's plane, the front edge up
};

/// An ellipsoid.
struct HeadTruth {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();     ///< [m] in the vehicle frame
  Eigen::Vector3d semi_axes = Eigen::Vector3d::Zero();  ///< [m] to the face, to the left ear, to the crown
  Eigen::Quaterniond vehicle_from_head = Eigen::Quaterniond::Identity();
};

/// What is true of a scene, known to no sensor.
///
/// The decision: fire for a passenger of whom nothing is in a zone; depowered for one who reaches into the outer zone
/// only, and for a child in a booster; no fire for whoever reaches into the critical zone, and for all else (nobody to
/// protect, or somebody whom an airbag of any power may harm).
struct CockpitTruth {
  CabinClass seat_class = CabinClass::kEmpty;
  CabinGroup group = CabinGroup::kEmpty;
  CabinDecision decision = CabinDecision::kNoFire;
  SeatSetting seat;
  std::optional<HeadTruth> head;  ///< of passengers and children
  /// From the dashboard's plane to the nearest place of what is on the seat, within the zones' height and width [m];
  /// infinite when nothing is.
  double dashboard_distance_m = std::numeric_limits<double>::infinity();
  Eigen::Vector3d nearest_place = Eigen::Vector3d::Zero();  ///< [m] that place, when there is one
};

CabinGroup group_of(CabinClass seat_class);
CabinDecision decision_of(CabinClass seat_class, double dashboard_distance_m, const CabinLayout& layout);

}  // namespace raybundle
