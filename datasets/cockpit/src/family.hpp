// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/cockpit/cockpit.hpp"
#include "raybundle/synthetic/random.hpp"
#include "skeleton.hpp"

namespace raybundle {

using Meshes = std::vector<CabinMesh>;

enum class Age { kAdult, kSchoolchild, kToddler, kBaby };

/// How a passenger sits.
enum class Sitting {
  kNormal,
  kLeaningForward,
  kHeadOnDashboard,
  kFeetUp,
  kReachingForward,
  kTurned,
  kOnTheEdge,
  kKneeling
};

/// A body and how it is dressed.
struct Person {
  BodySize size;
  CabinMaterial skin, hair, shirt, trousers, shoes;
  bool cap = false;
  double clothes_m = 0.01;  ///< thickness
};

/// Where a child seat or booster holds a child.
struct ChildPlace {
  Eigen::Vector3d hips = Eigen::Vector3d::Zero();  ///< [vehicle frame]
  double recline_rad = 0.0;                        ///< of the back, against the direction the child looks in
  bool looks_back = false;
};

/// A car maker's cabins and the people and things in them. Everything is drawn from the Random that is handed in.
struct CabinFamily {
  CabinLayout (*layout)(Random& random);
  SeatSetting (*seat_setting)(const CabinLayout& layout, Random& random);
  void (*add_car)(const CabinLayout& layout, Random& random, Meshes& meshes);
  void (*add_seat)(const SeatSetting& seat, Random& random, Meshes& meshes);

  Person (*person)(Age age, Random& random);
  Posture (*posture)(const BodySize& size, Sitting sitting, const SeatSetting& seat, const CabinLayout& layout,
                     Random& random);
  void (*add_person)(const Person& person, const Skeleton& skeleton, Meshes& meshes);

  ChildPlace (*add_booster)(const SeatSetting& seat, Random& random, Meshes& meshes);
  ChildPlace (*add_forward_baby_seat)(const SeatSetting& seat, Random& random, Meshes& meshes);
  ChildPlace (*add_rear_baby_seat)(const SeatSetting& seat, Random& random, Meshes& meshes);
  void (*add_objects)(const SeatSetting& seat, Random& random, Meshes& meshes);
};

const CabinFamily& training_family();
const CabinFamily& test_family();

}  // namespace raybundle
