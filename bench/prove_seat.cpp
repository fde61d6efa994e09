// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// The seat's setting from depth of 128x128 stereo in simulated cabins: as it is told once somebody has sat down on a
// seat that was watched while it was empty, and what is told of a seat that was never seen empty.
// usage: prove_seat [scenes of each, default 40]
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <vector>

#include "each_index.hpp"
#include "occupancy_scenes.hpp"
#include "raybundle/occupancy/seat_fit.hpp"
#include "support/bar.hpp"

namespace {

using namespace raybundle;
using namespace raybundle::apps;
using namespace raybundle::bench;

constexpr double kMost_m = 0.01, kMost_rad = 2 * M_PI / 180, kLeastFound = 0.95, kLeastRight = 0.95;
constexpr double kMostFalse = 0.01, kFrame_s = 0.1;
constexpr int kEmptyFrames = 16, kOccupiedFrames = 4, kThreads = 2;
constexpr std::uint64_t kSeed = 2100000000;

struct Trial {
  bool found = false, right = false, covered = false;
};

// The same seed is the same car with the same seat, whoever sits on it.
Trial trial(CockpitGenerator generator, std::uint64_t seed, int empty_frames, CabinClass wanted) {
  SeatWatch watch;
  SeatSetting truth;
  const auto look = [&](CabinClass seat_class, int frames) {
    const SceneSource source({SensorKind::kStereo, {generator, seed, seat_class, 0.0}, {11, 11}});
    for (int frame = 0; frame < frames; ++frame) {
      const MeasuredScene scene = source.at(frame * kFrame_s);
      watch.add(fit_seat(scene.layout, scene.scan()));
      truth = scene.truth.seat;
    }
  };
  look(CabinClass::kEmpty, empty_frames);
  look(wanted, kOccupiedFrames);
  const SeatFit seat = watch.seat();
  const Eigen::Vector2d off = seat.pose.bight - Eigen::Vector2d(truth.bight.x(), truth.bight.z());
  const bool turned = std::abs(seat.pose.recline_rad - truth.recline_rad) > kMost_rad;
  return {.found = seat.found,
          .right = seat.found && off.norm() < kMost_m && !turned,
          .covered = (off.cwiseAbs().array() < 3.0 * seat.bight_sigma_m.array()).all()};
}

bool prove(CockpitGenerator generator, int scenes) {
  constexpr CabinClass kOccupied[] = {CabinClass::kPassenger, CabinClass::kOutOfPosition, CabinClass::kChildInBooster,
                                      CabinClass::kForwardBabySeat};
  bool good = true;
  std::printf("%s: %d seats, %d frames empty, then %d with somebody on them\n",
              generator == CockpitGenerator::kTraining ? "training" : "held-out", scenes, kEmptyFrames,
              kOccupiedFrames);
  for (const int empty_frames : {kEmptyFrames, 0}) {
    std::vector<Trial> trials(static_cast<std::size_t>(scenes));
    for_each_index(trials.size(), kThreads, [&](std::size_t i) {
      trials[i] = trial(generator, kSeed + i, empty_frames, kOccupied[i % std::size(kOccupied)]);
    });
    double found = 0.0, right = 0.0, wrong = 0.0;
    for (const Trial& trial : trials) {
      found += trial.found;
      right += trial.right;
      wrong += trial.found && !trial.right && !trial.covered;
    }
    if (empty_frames > 0) {
      good &= at_least(kLeastFound, "seats told", found / scenes, kPercent);
      good &= at_least(kLeastRight, "of them within 1 cm and 2 degrees", right / std::max(1.0, found), kPercent);
    } else {
      std::printf("never seen empty: %.1f %% told\n", 100 * found / scenes);
      good &= at_most(kMostFalse, "told, wrong, and beyond three of their sigmas", wrong / scenes, kPercent);
    }
  }
  return good;
}

}  // namespace

int main(int argc, char** argv) {
  const int scenes = argc > 1 ? std::atoi(argv[1]) : 40;
  if (scenes < 1) {
    std::fprintf(stderr, "usage: prove_seat [scenes of each, at least 1]\n");
    return 2;
  }
  const bool training = prove(CockpitGenerator::kTraining, scenes), held_out = prove(CockpitGenerator::kTest, scenes);
  return training && held_out ? 0 : 1;
}
