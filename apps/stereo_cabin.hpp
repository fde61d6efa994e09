// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "raybundle/geometry/rigid3.hpp"
#include "raybundle/occupancy/head.hpp"
#include "raybundle/occupancy/seat_fit.hpp"
#include "raybundle/stereo/stereo.hpp"

namespace raybundle::apps {

/// A pair of cameras in a car, as vehicle.toml says: docs/formats/stereo.md.
struct StereoCabin {
  VehicleLayout layout;
  Rigid3 vehicle_from_rig;
};

/// @throws Error(kIo) when it cannot be read; Error(kBadInput) naming file and key
StereoCabin read_stereo_cabin(const std::string& path);

/// Seat and head in the frames of a sequence, in their order.
class CabinWatch {
 public:
  CabinWatch(const StereoCabin& cabin, const Rectification& pair);

  /// What one more frame tells: the "cabin" of docs/formats/stereo.md.
  nlohmann::ordered_json take(const StereoFrame& frame);

  /// The same as last told, for a frame of stereo_page: `drawn` (lines in the rectified frame, [x, y, z, ...] with a
  /// `colour`), `turn` and `cabin`.
  nlohmann::json on_page() const;

  /// The seat as it is known after that frame.
  SeatPose seat() const { return watch_.pose(); }

  /// In a few words, for a row of a table.
  std::string words() const;

 private:
  nlohmann::json drawn() const;
  nlohmann::json turn() const;
  Scan scan_of(const StereoFrame& frame);
  double chin_m() const;

  StereoCabin cabin_;
  Rigid3 vehicle_from_rectified_;
  SeatWatch watch_;
  Head head_;
  std::vector<ScenePoint> points_;
};

}  // namespace raybundle::apps
