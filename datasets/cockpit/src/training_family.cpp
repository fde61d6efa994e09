// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "training.hpp"

namespace raybundle {
namespace {

class TrainingFamily final : public CabinFamily {
 public:
  CabinLayout layout(Random& random) const override {
    CabinLayout layout;
    layout.dashboard_x_m = random.uniform(0.68, 0.74);
    layout.dashboard_top_m = random.uniform(0.43, 0.49);
    return layout;
  }
  SeatSetting seat_setting(const CabinLayout& layout, Random& random) const override {
    const Eigen::Vector3d h_point(random.uniform(-layout.track_m, layout.track_m), 0,
                                  random.uniform(-layout.lift_m, layout.lift_m));
    const double recline = layout.least_recline_rad + (layout.most_recline_rad - layout.least_recline_rad) *
                                                          random.uniform() * random.uniform(0.5, 1);
    return seat_setting_of(h_point, recline, random.uniform(0.19, 0.25), 0.095, 0.13);
  }
  void add_car(const CabinLayout& layout, Random& random, Meshes& meshes) const override {
    training::add_car(layout, random, meshes);
  }
  void add_seat(const SeatSetting& seat, Random& random, Meshes& meshes) const override {
    training::add_seat(seat, random, meshes);
  }
  Person person(Age age, Random& random) const override { return training::person(age, random); }
  Posture posture(const BodySize& size, Sitting sitting, const SeatSetting& seat, const CabinLayout& layout,
                  Random& random) const override {
    return training::posture(size, sitting, seat, layout, random);
  }
  void add_person(const Person& person, const Skeleton& skeleton, Meshes& meshes) const override {
    training::add_person(person, skeleton, meshes);
  }
  ChildPlace add_booster(const SeatSetting& seat, Random& random, Meshes& meshes) const override {
    return training::add_booster(seat, random, meshes);
  }
  ChildPlace add_forward_baby_seat(const SeatSetting& seat, Random& random, Meshes& meshes) const override {
    return training::add_forward_baby_seat(seat, random, meshes);
  }
  ChildPlace add_rear_baby_seat(const SeatSetting& seat, Random& random, Meshes& meshes) const override {
    return training::add_rear_baby_seat(seat, random, meshes);
  }
  void add_objects(const SeatSetting& seat, Random& random, Meshes& meshes) const override {
    training::add_objects(seat, random, meshes);
  }
};

}  // namespace

const CabinFamily& training_family() {
  static const TrainingFamily family;
  return family;
}

}  // namespace raybundle
