// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "family.hpp"
#include "seat_axes.hpp"

// The training family: seats of upholstered pads with bolsters, bodies of round cones.

namespace raybundle::training {

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

/// Cloth, plastic or leather of a random brightness.
CabinMaterial cloth(Random& random, double low_albedo, double high_albedo);

}  // namespace raybundle::training
