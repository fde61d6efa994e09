// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "occupancy_learning.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "occupancy_chain.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/threads.hpp"
#include "raybundle/synthetic/random.hpp"

namespace raybundle::apps {

const AttributeSet& attribute_set_of(SensorKind kind) {
  return kind == SensorKind::kStructuredLight ? kStripes : kBoxes;
}

SensorKind sensor_kind_of(const CaseBase& base) {
  return base.attribute_set == kBoxes.name ? SensorKind::kStereo : SensorKind::kStructuredLight;
}

std::vector<SituationClass> cabin_situations() {
  std::vector<SituationClass> situations;
  for (int c = 0; c < kCabinClasses; ++c) {
    const auto cabin = static_cast<CabinClass>(c);
    const bool inert =
        cabin == CabinClass::kEmpty || cabin == CabinClass::kEmptyBooster || cabin == CabinClass::kObjects;
    situations.push_back({std::string(kCabinClassNames[c]), static_cast<int>(group_of(cabin)), inert});
  }
  return situations;
}

std::vector<std::string> cabin_groups() { return {kCabinGroupNames.begin(), kCabinGroupNames.end()}; }

namespace {

// What is right for somebody of the truth's class at that distance, in the vehicle's zones.
CabinDecision decision_at(const CockpitTruth& truth, double dashboard_distance_m, const VehicleLayout& vehicle) {
  CabinLayout zones;
  zones.critical_m = vehicle.critical_m;
  zones.out_of_position_m = vehicle.out_of_position_m;
  return decision_of(truth.seat_class, dashboard_distance_m, zones);
}

// What would be right if whoever is there were nearer by a margin. Dense points show whether the outer zone is free:
// for them, cases say what would be right if it were.
AirbagAction action_to_learn(const MeasuredScene& scene, const SimulatedLearning& how) {
  CabinDecision decision = decision_at(scene.truth, scene.truth.dashboard_distance_m - how.margin_m, scene.layout);
  if (how.kind == SensorKind::kStereo && decision == CabinDecision::kDepowered) {
    decision = decision_at(scene.truth, INFINITY, scene.layout);
  }
  switch (decision) {
    case CabinDecision::kFire:
      return AirbagAction::kFire;
    case CabinDecision::kDepowered:
      return AirbagAction::kDepowered;
    case CabinDecision::kNoFire:
      return AirbagAction::kNoFire;
  }
  return AirbagAction::kNoFire;
}

// As a runtime would have fitted it to pairs as small as those that are learnt from, when the seat was empty; not known
// when it never was.
std::optional<SeatPose> seat_as_known(const SeatSetting& truth, const SimulatedLearning& how, std::uint64_t seed) {
  Random random(seed, 73);
  if (random.chance(how.seat_unseen)) return std::nullopt;
  SeatPose seat = seat_pose(truth);
  for (double& x_m : seat.bight) x_m += how.seat_sigma_m * random.normal();
  for (double* angle_rad : {&seat.recline_rad, &seat.cushion_pitch_rad}) {
    *angle_rad += how.seat_sigma_rad * random.normal();
  }
  return seat;
}

// A smooth field of random waves, of unit scatter.
class Waves {
 public:
  explicit Waves(Random& random) {
    constexpr double kShortest_m = 0.15, kLongest_m = 0.7;
    for (Wave& wave : waves_) {
      const double length_m = random.uniform(kShortest_m, kLongest_m);
      const double x = random.normal(), y = random.normal(), z = random.normal();
      wave.per_m = 2 * M_PI / length_m * Eigen::Vector3d(x, y, z).normalized();
      wave.phase = random.uniform(0.0, 2 * M_PI);
      wave.height = random.normal() * length_m / kLongest_m;  // long waves are the higher ones
    }
  }

  double at(const Eigen::Vector3d& x) const {
    double sum = 0.0;
    for (const Wave& wave : waves_) sum += wave.height * std::sin(wave.per_m.dot(x) + wave.phase);
    return sum;
  }

 private:
  struct Wave {
    Eigen::Vector3d per_m = Eigen::Vector3d::Zero();
    double phase = 0.0, height = 0.0;
  };
  std::array<Wave, 8> waves_;
};

// Of a car that is stretched and then shifted.
SeatPose moved_seat(const SeatPose& seat, const Eigen::Matrix3d& stretch, const Eigen::Vector3d& shift) {
  const auto turned = [&](const Eigen::Vector2d& x) -> Eigen::Vector3d {
    return stretch * Eigen::Vector3d(x.x(), 0.0, x.y());
  };
  const Eigen::Vector3d bight = turned(seat.bight) + shift, up = turned(seat.back_up()),
                        forward = turned(seat.cushion_forward());
  return {{bight.x(), bight.z()}, std::atan2(-up.x(), up.z()), std::atan2(forward.z(), forward.x())};
}

// Cases that vote, and which of them judge: the last ones.
int voting_of(const SimulatedLearning& how) { return std::min(how.most_voting, how.scenes / 4); }
int judging_of(const SimulatedLearning& how) { return (voting_of(how) + 1) / 2; }

// The car that a voting case is seen in, 0 its own.
std::size_t car_of_vote(const SimulatedLearning& how, int vote) {
  const bool judges = vote + judging_of(how) >= voting_of(how);
  return judges ? 0 : static_cast<std::size_t>((how.scenes - voting_of(how) + vote) % (1 + how.other_cars));
}

std::uint64_t seed_in_car(std::uint64_t seed, std::size_t car) {
  return car == 0 ? seed : mixed_bits(mixed_bits(seed) + car);
}

}  // namespace

SimulatedLearning learning_of(SensorKind kind) {
  SimulatedLearning learning;
  learning.kind = kind;
  if (kind == SensorKind::kStereo) learning.scenes = 24000;
  return learning;
}

MeasuredScene as_in_another_car(MeasuredScene scene, const SimulatedLearning& how, std::uint64_t seed) {
  Random random(seed, 71);
  const auto change = [&](double most) { return random.uniform(-most, most); };
  Eigen::Matrix3d stretch = Eigen::Matrix3d::Identity();
  for (int i = 0; i < 3; ++i) stretch(i, i) += change(how.car_change);
  stretch(2, 0) = change(how.car_change);
  const double x = change(how.car_shift_m), y = change(0.5 * how.car_shift_m), z = change(how.car_shift_m);
  const Eigen::Vector3d shift(x, y, z);
  const Waves shape(random);
  const Eigen::Vector3d eye = stretch * scene.viewpoint_in_vehicle + shift;
  const auto moved = [&](const Eigen::Vector3d& place, bool dented) -> Eigen::Vector3d {
    const Eigen::Vector3d at = stretch * place + shift;
    return dented ? Eigen::Vector3d(at + how.car_shape_m * shape.at(at) * (at - eye).normalized()) : at;
  };
  MeasuredScene other = scene;
  VehicleLayout& layout = other.layout;
  const double dashboard_x_m = layout.dashboard_x_m;
  const auto height = [&](double z_m) { return moved({dashboard_x_m, 0.0, z_m}, false).z(); };
  layout.dashboard_top_m = height(layout.dashboard_top_m);
  layout.zone_floor_m = height(layout.zone_floor_m);
  layout.dashboard_x_m = moved({dashboard_x_m, 0.0, 0.0}, false).x();
  if (scene.seat) other.seat = moved_seat(*scene.seat, stretch, shift);
  other.viewpoint_in_vehicle = eye;
  other.points.clear(), other.parts.clear(), other.true_points.clear();
  for (std::size_t i = 0; i < scene.points.size(); ++i) {
    if (random.chance(how.car_lost)) continue;
    const bool dented = scene.parts[i] != CabinPart::kDashboard;  // where that is has been measured
    other.points.push_back(scene.points[i]);
    other.points.back().x_in_vehicle = moved(scene.points[i].x_in_vehicle, dented);
    other.parts.push_back(scene.parts[i]);
  }
  CockpitTruth& truth = other.truth;
  if (!std::isfinite(truth.dashboard_distance_m)) return other;
  truth.nearest_place = moved(truth.nearest_place, true);
  truth.dashboard_distance_m = std::max(0.0, layout.dashboard_x_m - truth.nearest_place.x());
  if (truth.seat_class == CabinClass::kPassenger || truth.seat_class == CabinClass::kOutOfPosition) {
    const bool outside = truth.dashboard_distance_m < layout.out_of_position_m;
    truth.seat_class = outside ? CabinClass::kOutOfPosition : CabinClass::kPassenger;
  }
  truth.decision = decision_at(truth, truth.dashboard_distance_m, layout);
  return other;
}

LabelledCases simulated_cases(const SimulatedLearning& how) {
  const AttributeSet& set = attribute_set_of(how.kind);
  const int copies = 1 + how.other_cars, voting = voting_of(how), learnt = how.scenes - voting;
  const auto cases_count = static_cast<std::size_t>(learnt) * copies + voting;
  LabelledCases cases{.attribute_set = std::string(set.name),
                      .situations = cabin_situations(),
                      .group_names = cabin_groups(),
                      .attributes = Eigen::MatrixXd(set.size, static_cast<Eigen::Index>(cases_count)),
                      .classes = std::vector<std::uint8_t>(cases_count),
                      .actions = std::vector<AirbagAction>(cases_count),
                      .voting = voting,
                      .judging = judging_of(how)};
  const auto add = [&](std::size_t n, const MeasuredScene& seen) {
    const SeatPose seat = seen.seat.value_or(SeatPose{});  // amid its travel, as the monitor takes it
    cases.attributes.col(static_cast<Eigen::Index>(n)) = set.attributes(seen.layout, seat, seen.scan());
    cases.classes[n] = static_cast<std::uint8_t>(seen.truth.seat_class);
    cases.actions[n] = action_to_learn(seen, how);
  };
  for_each_index(static_cast<std::size_t>(how.scenes), how.threads, [&](std::size_t i) {
    const std::uint64_t seed = how.seed + i;
    const CabinScene cabin(make_cockpit({CockpitGenerator::kTraining, seed, {}, 0.0}));
    const auto seen_in_car = [&](std::size_t car) {
      const std::uint64_t sensor_seed = seed_in_car(seed, car);
      const SceneRequest request{how.kind, {CockpitGenerator::kTraining, sensor_seed, {}, 0.0}, how.grid};
      MeasuredScene scene = how.kind == SensorKind::kStereo ? ChainSource(request).measured(cabin, 0.0)
                                                            : SceneSource(request).measured(cabin, 0.0);
      if (how.kind == SensorKind::kStereo) scene.seat = seat_as_known(scene.truth.seat, how, sensor_seed);
      return car == 0 ? scene : as_in_another_car(scene, how, sensor_seed);
    };
    const auto first_voting = static_cast<std::size_t>(learnt), all = static_cast<std::size_t>(copies);
    if (i < first_voting) {
      for (std::size_t car = 0; car < all; ++car) add(i * all + car, seen_in_car(car));
    } else {
      const std::size_t vote = i - first_voting;
      add(first_voting * all + vote, seen_in_car(car_of_vote(how, static_cast<int>(vote))));
    }
    if (how.scene_done) how.scene_done();
  });
  return cases;
}

void require_votes(const SimulatedLearning& how, int neighbours) {
  std::array<int, kCabinClasses> votes{};
  for (int vote = 0; vote < voting_of(how); ++vote) {
    if (*std::ranges::min_element(votes) > neighbours) return;
    const std::uint64_t seed = how.seed + static_cast<std::uint64_t>(how.scenes - voting_of(how) + vote);
    const Cockpit cockpit = make_cockpit({CockpitGenerator::kTraining, seed, {}, 0.0});
    MeasuredScene scene;  // without points: the truth does not depend on them
    scene.layout = vehicle_layout(cockpit.layout);
    scene.truth = cockpit.truth;
    const std::size_t car = car_of_vote(how, vote);
    if (car != 0) scene = as_in_another_car(std::move(scene), how, seed_in_car(seed, car));
    ++votes[static_cast<std::size_t>(scene.truth.seat_class)];
  }
  const auto fewest = std::ranges::min_element(votes);
  if (*fewest > neighbours) return;
  throw Error(
      ErrorKind::kNotEnoughData,
      fmt::format("class '{}' would have {} of the {} cases that vote, a quarter of the scenes, and more than {} "
                  "are needed: take more --scenes, or fewer --neighbours",
                  kCabinClassNames[static_cast<std::size_t>(fewest - votes.begin())], *fewest, voting_of(how),
                  neighbours));
}

}  // namespace raybundle::apps
