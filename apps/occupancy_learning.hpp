// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "occupancy_scenes.hpp"
#include "raybundle/occupancy/attributes.hpp"
#include "raybundle/occupancy/learn.hpp"

namespace raybundle::apps {

/// The attributes that a sensor's points are described by.
const AttributeSet& attribute_set_of(SensorKind kind);

/// The sensor whose points a base was learnt from.
SensorKind sensor_kind_of(const CaseBase& base);

/// The classes of the simulated cabins, in the order of CabinClass.
std::vector<SituationClass> cabin_situations();
std::vector<std::string> cabin_groups();

struct SimulatedLearning {
  SensorKind kind = SensorKind::kStructuredLight;
  LaserGrid grid{11, 11};
  int scenes = 120000;
  std::uint64_t seed = 1;
  int most_voting = 16000;     ///< scenes that are not learnt from but vote, at most a quarter: see LabelledCases
  int other_cars = 1;          ///< of each scene, as another sensor sees it and as in another car: as_in_another_car()
  double car_change = 0.10;    ///< how much lengths and angles of those cars differ
  double car_shift_m = 0.04;   ///< how much their seats are elsewhere
  double car_shape_m = 0.015;  ///< how much surfaces there bulge otherwise
  double car_lost = 0.1;       ///< share of the points that are lost there
  double seat_unseen = 0.1;    ///< share of the cases of stereo that do not know how the seat is set
  double seat_sigma_m = 0.02;  ///< of where it is to the others: as fit_seat() errs before pairs of 128x128
  double seat_sigma_rad = 0.05;  ///< of its recline and pitch
  double margin_m = 0.05;        ///< actions are learnt as if everybody were nearer to the dashboard by this
  int threads = 1;
  std::function<void()> scene_done = {};  ///< called after each scene, from any thread
};

/// As many scenes as a sensor's points need, by what those cost.
SimulatedLearning learning_of(SensorKind kind);

/// The scene stretched, sheared, shifted and dented a little, together with the rays that measured it: another seat,
/// another mounting, another person. Rays stay rays, so that what hides what remains true; planes that stand across
/// the car stay such planes. The truth follows: who comes nearer to the dashboard may be out of position there.
MeasuredScene as_in_another_car(MeasuredScene scene, const SimulatedLearning& how, std::uint64_t seed);

/// Scenes of the training generator with the seeds from `seed` on, as cases: the laser's dots as a detector would make
/// them, stereo's points as the runtime makes them of rendered images.
///
/// The last of them vote: each of those is one case, in its own car or in another one; the last half of them, in their
/// own cars, judge.
LabelledCases simulated_cases(const SimulatedLearning& how);

/// Finds out before the work, not after it, whether enough of the cases will vote.
///
/// @throws Error(kNotEnoughData) as learn()
void require_votes(const SimulatedLearning& how, int neighbours);

}  // namespace raybundle::apps
