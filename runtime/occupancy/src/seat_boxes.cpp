// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/seat_boxes.hpp"

namespace raybundle {
namespace {

constexpr double kHalfWidth_m = 0.26, kLength_m = 0.52, kHeight_m = 0.66, kThickness_m = 0.16;
constexpr double kPadding_m = 0.03;  // cushions rise so far above their planes
constexpr double kBodyDepth_m = 0.28, kHeadDepth_m = 0.45, kTop_m = 0.95, kLap_m = 0.35;

}  // namespace

std::array<Box, kSeatPlaces> seat_boxes(const SeatPose& seat, double chin_m) {
  const Eigen::Vector3d bight(seat.bight.x(), 0.0, seat.bight.y());
  const auto box = [&](double pitch_rad, double back, double low, double front, double high) {
    return Box{.origin = bight,
               .pitch_rad = pitch_rad,
               .low = {back, -kHalfWidth_m, low},
               .high = {front, kHalfWidth_m, high}};
  };
  const double cushion = seat.cushion_pitch_rad, back = seat.recline_rad;  // the back's normal rises by its recline
  return {box(cushion, 0.0, -kThickness_m, kLength_m, kPadding_m), box(back, -kThickness_m, 0.0, kPadding_m, kHeight_m),
          box(cushion, kBodyDepth_m, kPadding_m, kLength_m, kLap_m), box(back, kPadding_m, 0.0, kBodyDepth_m, chin_m),
          box(back, kPadding_m, chin_m, kHeadDepth_m, kTop_m)};
}

}  // namespace raybundle
