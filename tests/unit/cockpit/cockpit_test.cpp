// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/cockpit/cockpit.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <set>
#include <string>
#include <tuple>
#include <vector>

namespace raybundle {
namespace {

constexpr int kSeeds = 12;

Cockpit scene_of(CockpitGenerator generator, CabinClass wanted, int seed, double time_s = 0.0) {
  return make_cockpit({generator, static_cast<std::uint64_t>(seed), wanted, time_s});
}

// All bits of all vertices, in one number.
std::uint64_t fingerprint(const Cockpit& cockpit) {
  std::uint64_t sum = 0;
  for (const CabinMesh& mesh : cockpit.meshes) {
    for (const Eigen::Vector3f& vertex : mesh.vertices) {
      for (const float value : vertex) sum = sum * 1099511628211u + std::bit_cast<std::uint32_t>(value);
    }
  }
  return sum;
}

bool is_occupant(CabinPart part) { return part >= CabinPart::kHead; }

class EveryScene : public testing::TestWithParam<std::tuple<CockpitGenerator, CabinClass>> {
 protected:
  CockpitGenerator generator() const { return std::get<0>(GetParam()); }
  CabinClass wanted() const { return std::get<1>(GetParam()); }
};

TEST_P(EveryScene, HasTheSameBitsForTheSameSeedAndOthersForOthers) {
  std::set<std::uint64_t> prints;
  for (int seed = 1; seed <= 4; ++seed) {
    const std::uint64_t print = fingerprint(scene_of(generator(), wanted(), seed));
    EXPECT_EQ(print, fingerprint(scene_of(generator(), wanted(), seed)));
    prints.insert(print);
  }
  EXPECT_EQ(prints.size(), 4u);
}

TEST_P(EveryScene, IsOfTheClassThatWasAskedForAndItsLabelsAgree) {
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const Cockpit cockpit = scene_of(generator(), wanted(), seed);
    const CockpitTruth& truth = cockpit.truth;
    ASSERT_EQ(truth.seat_class, wanted());
    EXPECT_EQ(truth.group, group_of(wanted()));
    EXPECT_EQ(truth.decision, decision_of(wanted(), truth.dashboard_distance_m, cockpit.layout));
    if (std::isfinite(truth.dashboard_distance_m)) {
      EXPECT_EQ(truth.dashboard_distance_m, std::max(0.0, cockpit.layout.dashboard_x_m - truth.nearest_place.x()));
    }
    const bool someone = wanted() == CabinClass::kPassenger || wanted() == CabinClass::kOutOfPosition ||
                         wanted() == CabinClass::kChildInBooster;
    if (someone) {
      EXPECT_TRUE(truth.head.has_value());
    }
    if (wanted() == CabinClass::kPassenger) {
      EXPECT_GE(truth.dashboard_distance_m, cockpit.layout.out_of_position_m);
    }
    if (wanted() == CabinClass::kOutOfPosition) {
      EXPECT_LT(truth.dashboard_distance_m, cockpit.layout.out_of_position_m);
    }
  }
}

TEST_P(EveryScene, SetsTheSeatWithinItsTravelAndItsPlanesMeetInTheBight) {
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const Cockpit cockpit = scene_of(generator(), wanted(), seed);
    const SeatSetting& seat = cockpit.truth.seat;
    EXPECT_LE(std::abs(seat.h_point.x()), cockpit.layout.track_m);
    EXPECT_LE(std::abs(seat.h_point.z()), cockpit.layout.lift_m);
    EXPECT_GE(seat.recline_rad, cockpit.layout.least_recline_rad);
    EXPECT_LE(seat.recline_rad, cockpit.layout.most_recline_rad);
    // The H-point of a seat is some 9 to 10 cm above its cushion and 13 cm before its back [SAE J826 manikin].
    const Eigen::Vector3d up(-std::sin(seat.cushion_pitch_rad), 0, std::cos(seat.cushion_pitch_rad));
    const Eigen::Vector3d forward(std::cos(seat.recline_rad), 0, std::sin(seat.recline_rad));
    EXPECT_NEAR(up.dot(seat.h_point - seat.bight), 0.097, 0.005);
    EXPECT_NEAR(forward.dot(seat.h_point - seat.bight), 0.1275, 0.005);
  }
}

// What is on a seat sinks into its upholstery, but not through it: flesh and foam together give way by up to 9 cm.
TEST_P(EveryScene, HasNothingDeepInTheCushionOrTheBack) {
  if (wanted() == CabinClass::kEmpty || wanted() == CabinClass::kOutOfPosition) GTEST_SKIP() << "nobody sits there";
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const Cockpit cockpit = scene_of(generator(), wanted(), seed);
    const SeatSetting& seat = cockpit.truth.seat;
    const Eigen::Vector3d up(-std::sin(seat.cushion_pitch_rad), 0, std::cos(seat.cushion_pitch_rad));
    const Eigen::Vector3d forward(std::cos(seat.recline_rad), 0, std::sin(seat.recline_rad));
    std::vector<double> above, before;
    for (const CabinMesh& mesh : cockpit.meshes) {
      if (!is_occupant(mesh.part)) continue;
      for (const Eigen::Vector3f& vertex : mesh.vertices) {
        const Eigen::Vector3d from_bight = vertex.cast<double>() - seat.bight;
        if (std::abs(from_bight.y()) > 0.2) continue;  // elbows and blankets may hang beside the seat
        const double along =
            std::cos(seat.cushion_pitch_rad) * from_bight.x() + std::sin(seat.cushion_pitch_rad) * from_bight.z();
        const double upwards =
            -std::sin(seat.recline_rad) * from_bight.x() + std::cos(seat.recline_rad) * from_bight.z();
        if (along > 0.05 && along < 0.42) above.push_back(up.dot(from_bight));
        if (upwards > 0.10 && upwards < 0.55) before.push_back(forward.dot(from_bight));
      }
    }
    ASSERT_FALSE(above.empty());
    EXPECT_GT(*std::ranges::min_element(above), -0.09) << "seed " << seed;
    EXPECT_LT(*std::ranges::min_element(above), 0.08) << "it hovers; seed " << seed;
    if (!before.empty()) {
      EXPECT_GT(*std::ranges::min_element(before), -0.09) << "seed " << seed;
    }
  }
}

TEST_P(EveryScene, StaysInTheCabin) {
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const Cockpit cockpit = scene_of(generator(), wanted(), seed);
    const CabinLayout& layout = cockpit.layout;
    for (const CabinMesh& mesh : cockpit.meshes) {
      if (!is_occupant(mesh.part)) continue;
      for (const Eigen::Vector3f& v : mesh.vertices) {
        ASSERT_TRUE(v.allFinite());
        // Elbows may press against the door's lining, hair against the roof's.
        ASSERT_GT(v.y(), layout.door_y_m - 0.12) << "seed " << seed;
        ASSERT_LT(v.z(), layout.roof_m + 0.05) << "seed " << seed;
        ASSERT_GT(v.z(), -0.36) << "seed " << seed;
      }
    }
  }
}

std::string name_of(const testing::TestParamInfo<EveryScene::ParamType>& scene) {
  const auto [generator, wanted] = scene.param;
  const std::string family = generator == CockpitGenerator::kTraining ? "training_" : "test_";
  return family + std::string(kCabinClassNames[static_cast<std::size_t>(wanted)]);
}

INSTANTIATE_TEST_SUITE_P(All, EveryScene,
                         testing::Combine(testing::Values(CockpitGenerator::kTraining, CockpitGenerator::kTest),
                                          testing::Values(CabinClass::kEmpty, CabinClass::kPassenger,
                                                          CabinClass::kOutOfPosition, CabinClass::kEmptyBooster,
                                                          CabinClass::kChildInBooster, CabinClass::kForwardBabySeat,
                                                          CabinClass::kRearBabySeat, CabinClass::kObjects)),
                         name_of);

class EveryGenerator : public testing::TestWithParam<CockpitGenerator> {};

TEST_P(EveryGenerator, PutsHeadsWhereHeadsAre) {
  for (int seed = 1; seed <= 3 * kSeeds; ++seed) {
    const Cockpit cockpit = scene_of(GetParam(), CabinClass::kPassenger, seed);
    const Eigen::Vector3d& head = cockpit.truth.head->centre;
    const double above_hips = head.z() - cockpit.truth.seat.h_point.z();
    EXPECT_GT(above_hips, 0.33) << "seed " << seed;  // a child that lies in a reclined seat
    EXPECT_LT(above_hips, 0.88) << "seed " << seed;  // the 95th percentile's eyes are 0.80 m above the seat
    // The head's own surface surrounds the centre.
    Eigen::Vector3f low = Eigen::Vector3f::Constant(9), high = -low;
    for (const CabinMesh& mesh : cockpit.meshes) {
      if (mesh.part != CabinPart::kHead) continue;
      for (const Eigen::Vector3f& vertex : mesh.vertices) {
        low = low.cwiseMin(vertex);
        high = high.cwiseMax(vertex);
      }
    }
    EXPECT_TRUE((low.cast<double>().array() < head.array() - 0.05).all()) << "seed " << seed;
    EXPECT_TRUE((high.cast<double>().array() > head.array() + 0.05).all()) << "seed " << seed;
  }
}

TEST_P(EveryGenerator, MovesPassengersAndNothingElse) {
  for (int c = 0; c < kCabinClasses; ++c) {
    const auto wanted = static_cast<CabinClass>(c);
    const Cockpit now = scene_of(GetParam(), wanted, 3), later = scene_of(GetParam(), wanted, 3, 0.7);
    ASSERT_EQ(now.meshes.size(), later.meshes.size());
    float moved = 0;
    for (std::size_t m = 0; m < now.meshes.size(); ++m) {
      const CabinPart part = now.meshes[m].part;
      for (std::size_t i = 0; i < now.meshes[m].vertices.size(); ++i) {
        const float step = (now.meshes[m].vertices[i] - later.meshes[m].vertices[i]).norm();
        if (part == CabinPart::kHead || part == CabinPart::kBody || part == CabinPart::kBlanket)
          moved = std::max(moved, step);
        else
          ASSERT_EQ(step, 0.0F) << kCabinClassNames[static_cast<std::size_t>(c)];
      }
    }
    if (now.truth.head) {
      EXPECT_GT(moved, 0.002F) << kCabinClassNames[static_cast<std::size_t>(c)];
    }
    EXPECT_LT(moved, 0.3F);  // in 0.7 s
  }
}

TEST_P(EveryGenerator, DrawsAllClassesAlike) {
  std::array<int, kCabinClasses> counts{};
  for (std::uint64_t seed = 1; seed <= 160; ++seed) {
    ++counts[static_cast<std::size_t>(make_cockpit({.generator = GetParam(), .seed = seed}).truth.seat_class)];
  }
  for (const int count : counts) EXPECT_NEAR(count, 20, 16);  // 4 standard deviations of a binomial count
}

INSTANTIATE_TEST_SUITE_P(All, EveryGenerator, testing::Values(CockpitGenerator::kTraining, CockpitGenerator::kTest));

TEST(Generators, BuildScenesOfOtherParts) {
  for (int c = 0; c < kCabinClasses; ++c) {
    const auto wanted = static_cast<CabinClass>(c);
    EXPECT_NE(scene_of(CockpitGenerator::kTraining, wanted, 1).meshes.size(),
              scene_of(CockpitGenerator::kTest, wanted, 1).meshes.size());
  }
}

TEST(Decision, FollowsTheStatedRule) {
  const CabinLayout layout;
  const double near = 0.5 * layout.critical_m, between = 0.5 * (layout.critical_m + layout.out_of_position_m),
               far = layout.out_of_position_m + 0.1;
  EXPECT_EQ(decision_of(CabinClass::kPassenger, far, layout), CabinDecision::kFire);
  EXPECT_EQ(decision_of(CabinClass::kOutOfPosition, between, layout), CabinDecision::kDepowered);
  EXPECT_EQ(decision_of(CabinClass::kOutOfPosition, near, layout), CabinDecision::kNoFire);
  EXPECT_EQ(decision_of(CabinClass::kChildInBooster, far, layout), CabinDecision::kDepowered);
  EXPECT_EQ(decision_of(CabinClass::kChildInBooster, near, layout), CabinDecision::kNoFire);
  for (const CabinClass other : {CabinClass::kEmpty, CabinClass::kEmptyBooster, CabinClass::kForwardBabySeat,
                                 CabinClass::kRearBabySeat, CabinClass::kObjects}) {
    EXPECT_EQ(decision_of(other, far, layout), CabinDecision::kNoFire);
  }
}

}  // namespace
}  // namespace raybundle
