// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/cockpit/truth.hpp"

namespace raybundle {

CabinGroup group_of(CabinClass seat_class) {
  switch (seat_class) {
    case CabinClass::kEmpty:
      return CabinGroup::kEmpty;
    case CabinClass::kForwardBabySeat:
    case CabinClass::kRearBabySeat:
      return CabinGroup::kBabySeat;
    default:
      return CabinGroup::kSomething;
  }
}

CabinDecision decision_of(CabinClass seat_class, double dashboard_distance_m, const CabinLayout& layout) {
  const bool person = seat_class == CabinClass::kPassenger || seat_class == CabinClass::kOutOfPosition ||
                      seat_class == CabinClass::kChildInBooster;
  if (!person || dashboard_distance_m < layout.critical_m) return CabinDecision::kNoFire;
  const bool gently = seat_class == CabinClass::kChildInBooster || dashboard_distance_m < layout.out_of_position_m;
  return gently ? CabinDecision::kDepowered : CabinDecision::kFire;
}

}  // namespace raybundle
