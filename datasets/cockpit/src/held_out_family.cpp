// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "held_out.hpp"

namespace raybundle {
namespace {

class HeldOutFamily final : public CabinFamily {
 public:
  CabinLayout layout(Random& random) const override {
    CabinLayout layout;
    layout.dashboard_x_m = random.uniform(0.70, 0.78);
    layout.dashboard_top_m = random.uniform(0.41, 0.46);
    layout.track_m = 0.13;
    layout.lift_m = 0.025;
    layout.roof_m = 1.00;
    layout.door_y_m = -0.40;
    layout.middle_y_m = 0.36;
    return layout;
  }
  SeatSetting seat_setting(const CabinLayout& layout, Random& random) const override {
    const double track = layout.track_m * (2 * std::pow(random.uniform(), 0.8) - 1);
    const Eigen::Vector3d h_point(track, 0, random.uniform(-layout.lift_m, layout.lift_m));
    return seat_setting_of(h_point, random.uniform(layout.least_recline_rad + 0.03, layout.most_recline_rad - 0.03),
                           random.uniform(0.15, 0.22), 0.10, 0.125);
  }
  void add_car(const CabinLayout& layout, Random& random, Meshes& meshes) const override {
    held_out::add_car(layout, random, meshes);
  }
  void add_seat(const SeatSetting& seat, Random& random, Meshes& meshes) const override {
    held_out::add_seat(seat, random, meshes);
  }
  Person person(Age age, Random& random) const override { return held_out::person(age, random); }
  Posture posture(const BodySize& size, Sitting sitting, const SeatSetting& seat, const CabinLayout& layout,
                  Random& random) const override {
    return held_out::posture(size, sitting, seat, layout, random);
  }
  void add_person(const Person& person, const Skeleton& skeleton, Meshes& meshes) const override {
    held_out::add_person(person, skeleton, meshes);
  }
  ChildPlace add_booster(const SeatSetting& seat, Random& random, Meshes& meshes) const override {
    return held_out::add_booster(seat, random, meshes);
  }
  ChildPlace add_forward_baby_seat(const SeatSetting& seat, Random& random, Meshes& meshes) const override {
    return held_out::add_forward_baby_seat(seat, random, meshes);
  }
  ChildPlace add_rear_baby_seat(const SeatSetting& seat, Random& random, Meshes& meshes) const override {
    return held_out::add_rear_baby_seat(seat, random, meshes);
  }
  void add_objects(const SeatSetting& seat, Random& random, Meshes& meshes) const override {
    held_out::add_objects(seat, random, meshes);
  }
};

}  // namespace

const CabinFamily& test_family() {
  static const HeldOutFamily family;
  return family;
}

}  // namespace raybundle
