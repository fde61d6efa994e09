// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Occupancy in simulated cabins: learns on the training generator and judges other scenes of it (same vehicle) and of
// the test generator (held-out vehicle), for the laser and for stereo, each figure against its bar; what has no bar is
// marked as information. Stereo is the whole chain: rendered pairs, the runtime, the decision. The laser's
// dots are those that a runtime would make of its images; `chain` renders those, too, for fewer scenes, beside the same
// scenes without.
//
// usage: prove_occupancy [scenes of each split, default 3000] [scenes to learn, default 0: those of each sensor]
//                        [laser | stereo | chain]
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>

#include "occupancy_evaluation.hpp"
#include "occupancy_learning.hpp"
#include "support/bar.hpp"

namespace {

using namespace raybundle;
using namespace raybundle::apps;
using namespace raybundle::bench;

constexpr double kMostDangerous = 0.001;
constexpr double kDistance_m = 0.020;
constexpr std::uint64_t kUnlearntSeed = 1000000000;
constexpr int kThreads = 2;
constexpr int kScenesPerChain = 15;  // of so many scenes one goes through the whole chain

struct Split {
  const char* name;
  CockpitGenerator generator;
  double least_groups;   // of the laser's answers
  double least_classes;  // of stereo's
};
constexpr Split kSplits[] = {{"same vehicle", CockpitGenerator::kTraining, 0.99, 0.95},
                             {"held-out vehicle", CockpitGenerator::kTest, 0.95, 0.85}};

// Tells on stderr how far a long step is, each twentieth part of it.
std::function<void()> progress(std::string what, int all) {
  auto done = std::make_shared<std::atomic<int>>(0);
  return [done, what = std::move(what), all] {
    const int now = ++*done;
    if (now % std::max(1, all / 20) == 0) std::fprintf(stderr, "%s: %d of %d\n", what.c_str(), now, all);
  };
}

bool is_laser(SensorKind kind) { return kind == SensorKind::kStructuredLight; }

Evaluation evaluation_of(SensorKind kind, const CaseBase& base, const Split& split, int scenes, bool chain) {
  return evaluate(base, {.kind = kind,
                         .generator = split.generator,
                         .seed = kUnlearntSeed,
                         .scenes = scenes,
                         .monitor = monitor_options_of(kind),
                         .chain = chain,
                         .threads = kThreads,
                         .scene_done = progress(split.name, scenes)});
}

bool judge(SensorKind kind, const Evaluation& e, const Split& split) {
  const bool laser = is_laser(kind);
  bool good = laser ? at_least(split.least_groups, "3 groups right, of answers", e.right_group.value(), kPercent)
                    : at_least(split.least_classes, "8 classes right, of answers", e.right_class.value(), kPercent);
  good &= at_most(kMostDangerous, "dangerous fire", e.dangerous.value(), kPercent);
  const auto& fire = e.actions[static_cast<std::size_t>(CabinDecision::kFire)];
  const int to_fire = fire[0] + fire[1] + fire[2] + fire[3];
  if (laser && !e.distance_errors_m.empty()) {
    const double largest = std::abs(e.distance_errors_m.back());
    good &= at_most(kDistance_m, "distance of the dot told, largest error", largest, kMillimetres);
    good &= at_most(0.0, "a dot 20 mm nearer not told", e.nearer_missed.value(), kPercent);
  }
  std::printf("  information: of %d scenes to fire in: fire %d (%.1f %%), depowered %d, no fire %d, undecided %d\n",
              to_fire, fire[0], 100.0 * fire[0] / std::max(1, to_fire), fire[1], fire[2], fire[3]);
  std::printf(
      "  information: no answer: group %.2f %%, class %.2f %%; undecided %.2f %%; dangerous at most %.2f %% "
      "(95 %%)\n",
      100 * e.rejected_group.value(), 100 * e.rejected_class.value(), 100 * e.rejected_action.value(),
      100 * e.dangerous.high());
  if (!e.nearest_errors_m.empty()) {
    const auto at = [&](double share) {
      return 1e3 * std::abs(e.nearest_errors_m[static_cast<std::size_t>(
                       share * static_cast<double>(e.nearest_errors_m.size() - 1))]);
    };
    std::printf(
        "  information: somebody reaches nearer than what was told, unseen between the rays: median %.0f mm, "
        "95 %% within %.0f mm, largest %.0f mm\n",
        at(0.5), at(0.95), at(1.0));
  }
  std::fflush(stdout);
  return good;
}

bool prove(SensorKind kind, const CaseBase& base, const Split& split, int scenes) {
  std::printf("%s, %s: %d scenes\n", is_laser(kind) ? "laser 11x11" : "stereo 128x128", split.name, scenes);
  return judge(kind, evaluation_of(kind, base, split, scenes, false), split);
}

// The laser in the same scenes through images and runtime, and without.
bool prove_chain(const CaseBase& base, const Split& split, int scenes) {
  bool good = true;
  for (const bool chain : {false, true}) {
    std::printf("laser 11x11, %s: %d scenes, %s\n", split.name, scenes,
                chain ? "images through the whole chain" : "without images");
    const Evaluation e = evaluation_of(SensorKind::kStructuredLight, base, split, scenes, chain);
    const bool bars_hold = judge(SensorKind::kStructuredLight, e, split);
    good &= bars_hold || !chain;
  }
  return good;
}

}  // namespace

int main(int argc, char** argv) {
  const int scenes = argc > 1 ? std::atoi(argv[1]) : 3000, learnt = argc > 2 ? std::atoi(argv[2]) : 0;
  const std::string only = argc > 3 ? argv[3] : "";
  if (scenes < 1 || learnt < 0 || !(only.empty() || only == "laser" || only == "stereo" || only == "chain")) {
    std::fprintf(stderr,
                 "usage: prove_occupancy [scenes of each split, at least 1] [scenes to learn, 0: those of each sensor] "
                 "[laser | stereo | chain]\n");
    return 2;
  }
  bool good = true;
  for (const SensorKind kind : {SensorKind::kStructuredLight, SensorKind::kStereo}) {
    const char* name = is_laser(kind) ? "laser" : "stereo";
    if (!only.empty() && only != name && !(only == "chain" && is_laser(kind))) continue;
    SimulatedLearning learning = learning_of(kind);
    if (learnt > 0) learning.scenes = learnt;
    learning.threads = kThreads;
    learning.scene_done = progress(std::string("learning, ") + name, learning.scenes);
    const CaseBase base = learn(simulated_cases(learning), {.threads = kThreads});
    std::printf(
        "%s: learnt from %d scenes; information: groups are told from %.3f of the votes on, classes from %.3f\n", name,
        learning.scenes, base.sure_of_group, base.sure_of_situation);
    for (const Split& split : kSplits) {
      if (only != "chain") good &= prove(kind, base, split, scenes);
      if (is_laser(kind) && (only.empty() || only == "chain")) {
        good &= prove_chain(base, split, std::max(1, scenes / kScenesPerChain));
      }
    }
  }
  return good ? 0 : 1;
}
