// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// The seat's setting, through the whole chain: simulated cabins are rendered as a pair of 640x480 cameras sees them,
// the runtime rectifies, matches and triangulates, fit_seat looks at every third pixel, as `reconstruct stereo` does.
// Told is the seat that was watched while it was empty, before and after somebody has sat down on it, and what is told
// of a seat that was never seen empty. For information: the same before cameras of 128x128. usage: prove_seat [seats of
// each generator, default 100 [first seed]]
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <vector>

#include "occupancy_chain.hpp"
#include "raybundle/geometry/threads.hpp"
#include "raybundle/occupancy/seat_fit.hpp"
#include "support/bar.hpp"
#include "thinning.hpp"

namespace {

using namespace raybundle;
using namespace raybundle::apps;
using namespace raybundle::bench;

constexpr double kMost_m = 0.01, kMost_rad = 2 * M_PI / 180, kLeastFound = 0.95, kLeastRight = 0.95;
constexpr double kMostFalse = 0.01, kLeastCovered = 0.90, kFrame_s = 0.1;
constexpr int kEmptyFrames = 4, kOccupiedFrames = 2, kThreads = 2;
constexpr ImageSize kSize{640, 480}, kSmallSize{128, 128};
constexpr std::uint64_t kSeed = 2100000000;
constexpr CabinClass kOccupied[] = {CabinClass::kPassenger, CabinClass::kOutOfPosition, CabinClass::kChildInBooster,
                                    CabinClass::kForwardBabySeat};

// What is told of a seat, and the truth.
struct Told {
  bool found = false, right = false;
  bool covered[2] = {};  // by two, by three of its sigmas
};

Told told_of(const SeatFit& seat, const SeatSetting& truth) {
  const Eigen::Vector2d off = seat.pose.bight - seat_pose(truth).bight;
  const bool turned = std::abs(seat.pose.recline_rad - truth.recline_rad) > kMost_rad;
  Told told{.found = seat.found, .right = seat.found && off.norm() < kMost_m && !turned};
  for (int i = 0; i < 2; ++i) told.covered[i] = (off.cwiseAbs().array() < (2.0 + i) * seat.bight_sigma_m.array()).all();
  return told;
}

struct Trial {
  Told empty, occupied, never_empty;
};

// The same seed is the same car with the same seat, whoever sits on it.
Trial trial(CockpitGenerator generator, std::uint64_t seed, CabinClass wanted, ImageSize size) {
  ChainSource source(
      {SensorKind::kStereo, {generator, seed, CabinClass::kEmpty, 0.0}, {11, 11}, size, kMostCabinPoints});
  SeatWatch watch, late_watch;
  Trial trial;
  for (int frame = 0; frame < kEmptyFrames + kOccupiedFrames; ++frame) {
    const double time_s = frame * kFrame_s;
    const bool empty = frame < kEmptyFrames;
    const MeasuredScene scene = source.measured(
        CabinScene(make_cockpit({generator, seed, empty ? CabinClass::kEmpty : wanted, time_s})), time_s);
    const SeatFit fit = fit_seat(scene.layout, scene.scan());
    watch.add(fit);
    if (!empty) late_watch.add(fit);
    (empty ? trial.empty : trial.occupied) = told_of(watch.seat(), scene.truth.seat);
    trial.never_empty = told_of(late_watch.seat(), scene.truth.seat);
  }
  return trial;
}

std::vector<Trial> trials_of(CockpitGenerator generator, int seats, std::uint64_t seed, ImageSize size) {
  std::vector<Trial> trials(static_cast<std::size_t>(seats));
  for_each_index(trials.size(), kThreads, [&](std::size_t i) {
    trials[i] = trial(generator, seed + i, kOccupied[i % std::size(kOccupied)], size);
  });
  return trials;
}

template <typename Is>
double share(const std::vector<Trial>& trials, Is&& is) {
  double count = 0.0;
  for (const Trial& trial : trials) count += is(trial);
  return count / static_cast<double>(trials.size());
}

double found(const std::vector<Trial>& trials, Told Trial::*told) {
  return share(trials, [told](const Trial& trial) { return (trial.*told).found; });
}

double right(const std::vector<Trial>& trials, Told Trial::*told) {
  return share(trials, [told](const Trial& trial) { return (trial.*told).right; }) /
         std::max(1e-9, found(trials, told));
}

bool prove(CockpitGenerator generator, int seats, std::uint64_t seed) {
  const char* name = generator == CockpitGenerator::kTraining ? "training" : "held-out";
  const std::vector<Trial> trials = trials_of(generator, seats, seed, kSize);
  std::printf("%s: %d seats, %d frames of %dx%d empty, then %d with somebody on them\n", name, seats, kEmptyFrames,
              kSize.width, kSize.height, kOccupiedFrames);
  bool good = at_least(kLeastFound, "empty seats told", found(trials, &Trial::empty), kPercent);
  good &= at_least(kLeastRight, "of them within 1 cm and 2 degrees", right(trials, &Trial::empty), kPercent);
  for (int i = 0; i < 2; ++i) {
    const double covered = share(trials, [i](const Trial& t) { return t.empty.found && t.empty.covered[i]; });
    const char* what = i == 0 ? "of them within two of their sigmas" : "of them within three of their sigmas";
    good &= at_least(kLeastCovered + 0.07 * i, what, covered / std::max(1e-9, found(trials, &Trial::empty)), kPercent);
  }
  good &= at_least(kLeastFound, "told once somebody sits on them", found(trials, &Trial::occupied), kPercent);
  good &= at_least(kLeastRight, "of them within 1 cm and 2 degrees", right(trials, &Trial::occupied), kPercent);
  const double wrong = share(trials, [](const Trial& trial) {
    return trial.never_empty.found && !trial.never_empty.right && !trial.never_empty.covered[1];
  });
  good &= at_most(kMostFalse, "never seen empty, told wrong and beyond 3 sigmas", wrong, kPercent);
  const std::vector<Trial> small = trials_of(generator, std::max(1, seats / 2), seed, kSmallSize);
  std::printf("  information: %dx%d: %.1f %% of empty seats told, of them %.1f %% within 1 cm and 2 degrees\n",
              kSmallSize.width, kSmallSize.height, 100 * found(small, &Trial::empty),
              100 * right(small, &Trial::empty));
  std::fflush(stdout);
  return good;
}

}  // namespace

int main(int argc, char** argv) {
  const int seats = argc > 1 ? std::atoi(argv[1]) : 100;
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : kSeed;
  if (seats < 1) {
    std::fprintf(stderr, "usage: prove_seat [seats of each generator, at least 1 [first seed]]\n");
    return 2;
  }
  bool good = true;
  for (const CockpitGenerator generator : {CockpitGenerator::kTraining, CockpitGenerator::kTest}) {
    good &= prove(generator, seats, seed);
  }
  return good ? 0 : 1;
}
