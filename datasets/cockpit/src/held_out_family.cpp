// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "held_out.hpp"

namespace raybundle {
namespace {

CabinLayout layout(Random& random) {
  CabinLayout layout;
  layout.dashboard_x_m = random.uniform(0.70, 0.78);
  layout.dashboard_top_m = random.uniform(0.41, 0.46);
  layout.track_m = 0.13;
  layout.lift_m = 0.025;
  layout.roof_m = 1.00;
  layout.door_y_m = -0.40;
  layout.middle_y_m = 0.36;
  layout.fixtures = {held_out::screen_of(layout).bounds()};
  return layout;
}

SeatSetting seat_setting(const CabinLayout& layout, Random& random) {
  const double track = layout.track_m * (2 * std::pow(random.uniform(), 0.8) - 1);
  const Eigen::Vector3d h_point(track, 0, random.uniform(-layout.lift_m, layout.lift_m));
  return seat_setting_of(h_point, random.uniform(layout.least_recline_rad + 0.03, layout.most_recline_rad - 0.03),
                         random.uniform(0.15, 0.22), 0.10, 0.125);
}

}  // namespace

const CabinFamily& test_family() {
  static constexpr CabinFamily family{
      .layout = layout,
      .seat_setting = seat_setting,
      .add_car = held_out::add_car,
      .add_seat = held_out::add_seat,
      .person = held_out::person,
      .posture = held_out::posture,
      .add_person = held_out::add_person,
      .add_booster = held_out::add_booster,
      .add_forward_baby_seat = held_out::add_forward_baby_seat,
      .add_rear_baby_seat = held_out::add_rear_baby_seat,
      .add_objects = held_out::add_objects,
  };
  return family;
}

}  // namespace raybundle
