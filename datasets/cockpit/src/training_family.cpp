// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "training.hpp"

namespace raybundle {
namespace {

CabinLayout layout(Random& random) {
  CabinLayout layout;
  layout.dashboard_x_m = random.uniform(0.66, 0.76);
  layout.dashboard_top_m = random.uniform(0.42, 0.50);
  return layout;
}

SeatSetting seat_setting(const CabinLayout& layout, Random& random) {
  const Eigen::Vector3d h_point(random.uniform(-layout.track_m, layout.track_m), 0,
                                random.uniform(-layout.lift_m, layout.lift_m));
  const double recline = random.uniform(layout.least_recline_rad, layout.most_recline_rad);
  return seat_setting_of(h_point, recline, random.uniform(0.16, 0.26), 0.095, 0.13);
}

}  // namespace

const CabinFamily& training_family() {
  static constexpr CabinFamily family{
      .layout = layout,
      .seat_setting = seat_setting,
      .add_car = training::add_car,
      .add_seat = training::add_seat,
      .person = training::person,
      .posture = training::posture,
      .add_person = training::add_person,
      .add_booster = training::add_booster,
      .add_forward_baby_seat = training::add_forward_baby_seat,
      .add_rear_baby_seat = training::add_rear_baby_seat,
      .add_objects = training::add_objects,
  };
  return family;
}

}  // namespace raybundle
