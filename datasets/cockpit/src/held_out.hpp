// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "family.hpp"
#include "seat_axes.hpp"

// The family that is held out: seats of rolls, bodies of ellipsoids.

namespace raybundle::held_out {

/// A screen that stands on the middle of the dashboard: a box, pitched about the car's y axis.
struct Screen {
  Eigen::Vector3d centre, semi_m;
  double pitch_rad;

  Eigen::AlignedBox3d bounds() const;
};
Screen screen_of(const CabinLayout& layout);

void add_car(const CabinLayout& layout, Random& random, Meshes& meshes);
void add_seat(const SeatSetting& seat, Random& random, Meshes& meshes);

Person person(Age age, Random& random);
Posture posture(const BodySize& size, Sitting sitting, const SeatSetting& seat, const CabinLayout& layout,
                Random& random);
void add_person(const Person& person, const Skeleton& skeleton, Meshes& meshes);

ChildPlace add_booster(const SeatSetting& seat, Random& random, Meshes& meshes);
ChildPlace add_forward_baby_seat(const SeatSetting& seat, Random& random, Meshes& meshes);
ChildPlace add_rear_baby_seat(const SeatSetting& seat, Random& random, Meshes& meshes);
void add_objects(const SeatSetting& seat, Random& random, Meshes& meshes);

/// What things of this family are covered with.
CabinMaterial fabric(Random& random, double low_albedo, double high_albedo);

}  // namespace raybundle::held_out
