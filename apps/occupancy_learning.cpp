// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "occupancy_learning.hpp"

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <vector>

#include "each_index.hpp"
#include "raybundle/synthetic/random.hpp"

namespace raybundle::apps {

const AttributeSet& attribute_set_of(SensorKind kind) {
  return kind == SensorKind::kStructuredLight ? kStripes : kBoxes;
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

// What would be right if whoever is there were nearer by a margin.
AirbagAction action_to_learn(const CockpitTruth& truth, const MeasuredScene& scene, double margin_m) {
  CabinLayout layout;
  layout.critical_m = scene.layout.critical_m;
  layout.out_of_position_m = scene.layout.out_of_position_m;
  switch (decision_of(truth.seat_class, truth.dashboard_distance_m - margin_m, layout)) {
    case CabinDecision::kFire:
      return AirbagAction::kFire;
    case CabinDecision::kDepowered:
      return AirbagAction::kDepowered;
    case CabinDecision::kNoFire:
      return AirbagAction::kNoFire;
  }
  return AirbagAction::kNoFire;
}

}  // namespace

namespace {

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

}  // namespace

MeasuredScene as_in_another_car(MeasuredScene scene, const SimulatedLearning& how, std::uint64_t seed) {
  Random random(seed, 71);
  const auto change = [&](double most) { return random.uniform(-most, most); };
  Eigen::Matrix3d stretch = Eigen::Matrix3d::Identity();
  for (int i = 0; i < 3; ++i) stretch(i, i) += change(how.car_change);
  stretch(0, 2) = change(how.car_change);
  stretch(2, 0) = change(how.car_change);
  const double x = change(how.car_shift_m), y = change(0.5 * how.car_shift_m), z = change(how.car_shift_m);
  const Eigen::Vector3d shift(x, y, z);
  const Waves shape(random);
  scene.viewpoint_in_vehicle = stretch * scene.viewpoint_in_vehicle + shift;
  std::erase_if(scene.points, [&](const ScenePoint&) { return random.chance(how.car_lost); });
  for (ScenePoint& point : scene.points) {
    point.x_in_vehicle = stretch * point.x_in_vehicle + shift;
    const Eigen::Vector3d ray = (point.x_in_vehicle - scene.viewpoint_in_vehicle).normalized();
    point.x_in_vehicle += how.car_shape_m * shape.at(point.x_in_vehicle) * ray;
  }
  return scene;
}

LabelledCases simulated_cases(const SimulatedLearning& how) {
  const AttributeSet& set = attribute_set_of(how.kind);
  LabelledCases cases{.attribute_set = std::string(set.name),
                      .situations = cabin_situations(),
                      .group_names = cabin_groups(),
                      .attributes = {},
                      .classes = {},
                      .actions = {}};
  const int copies = 1 + how.other_cars;
  cases.attributes.resize(set.size, static_cast<Eigen::Index>(how.scenes) * copies);
  cases.classes.resize(static_cast<std::size_t>(how.scenes) * copies);
  cases.actions.resize(cases.classes.size());
  for_each_index(static_cast<std::size_t>(how.scenes), how.threads, [&](std::size_t i) {
    const SceneRequest request{how.kind, {CockpitGenerator::kTraining, how.seed + i, {}, 0.0}, how.grid};
    const MeasuredScene scene = measured_scene(request);
    const AirbagAction action = action_to_learn(scene.truth, scene, how.margin_m);
    for (int copy = 0; copy < copies; ++copy) {
      const std::size_t n = i * copies + copy;
      const MeasuredScene seen =
          copy == 0 ? scene
                    : as_in_another_car(scene, how, mixed_bits(how.seed + i) + static_cast<std::uint64_t>(copy));
      cases.attributes.col(static_cast<Eigen::Index>(n)) = set.attributes(seen.layout, SeatPose{}, seen.scan());
      cases.classes[n] = static_cast<std::uint8_t>(seen.truth.seat_class);
      cases.actions[n] = action;
    }
    if (how.scene_done) how.scene_done();
  });
  return cases;
}

}  // namespace raybundle::apps
