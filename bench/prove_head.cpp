// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// The head of whoever is on the seat, through the whole chain: simulated cabins are rendered as a pair of 640x480
// cameras sees them, the runtime rectifies, matches and triangulates, find_head looks at every third pixel, as
// `reconstruct stereo` does; the seat's setting is given. How far the head's front (where the line from the sensor to
// its centre enters it) is from the true one, how often it is found, whether its sigma tells, and how often a head is
// found where none is. For information: the same of its centre, of its foremost place, and of people before smaller
// cameras. usage: prove_head [scenes of each class, default 60 [first seed]]
#include <Eigen/Cholesky>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "occupancy_chain.hpp"
#include "raybundle/geometry/quantile.hpp"
#include "raybundle/geometry/threads.hpp"
#include "raybundle/geometry/wilson.hpp"
#include "raybundle/occupancy/head.hpp"
#include "support/bar.hpp"
#include "thinning.hpp"

namespace {

using namespace raybundle;
using namespace raybundle::apps;
using namespace raybundle::bench;

constexpr double kMostMedian_m = 0.008, kMost95_m = 0.020;
constexpr double kLeastFound = 0.95, kMostFalse = 0.01;
constexpr double kLeastWithin[] = {0.60, 0.90, 0.97};     // at least, of one, two and three sigmas
constexpr double kChiSquared[] = {3.527, 8.025, 14.156};  // 68.3, 95.4 and 99.7 % of three normal variables
constexpr ImageSize kSize{640, 480};
constexpr int kVisible = 100;                // points on a head that is seen well
constexpr std::uint64_t kSeed = 2000000000;  // of the first scene
constexpr int kThreads = 2;

struct Trial {
  bool there = false, visible = false, found = false;
  double error_m = 0.0, chi_squared = 0.0, centre_error_m = 0.0, foremost_error_m = 0.0;
};

// Where the line from the eye to the centre of the true ellipsoid enters it.
Eigen::Vector3d front_of(const HeadTruth& head, const Eigen::Vector3d& eye) {
  const Eigen::Vector3d to_eye = eye - head.centre;
  return head.centre + to_eye / (head.vehicle_from_head.conjugate() * to_eye).cwiseQuotient(head.semi_axes).norm();
}

// Its place next to the dashboard's plane.
Eigen::Vector3d foremost_of(const Eigen::Vector3d& centre, const Eigen::Matrix3d& vehicle_from_head,
                            const Eigen::Vector3d& semi_axes) {
  const Eigen::Vector3d stretched = semi_axes.cwiseProduct(vehicle_from_head.row(0).transpose());
  return centre + vehicle_from_head * semi_axes.cwiseProduct(stretched.normalized());
}

Trial trial(CockpitGenerator generator, CabinClass wanted, std::uint64_t seed, ImageSize size) {
  const SceneRequest request{SensorKind::kStereo, {generator, seed, wanted, 0.0}, {11, 11}, size, kMostCabinPoints};
  const MeasuredScene scene = ChainSource(request).at(0.0);
  const Head head = find_head(scene.layout, seat_pose(scene.truth.seat), scene.scan());
  Trial trial{.there = scene.truth.head.has_value(), .found = head.found};
  trial.visible = trial.there && std::ranges::count(scene.parts, CabinPart::kHead) >= kVisible;
  if (!trial.there || !head.found) return trial;
  const HeadTruth& truth = *scene.truth.head;
  const Eigen::Vector3d error = head.front - front_of(truth, scene.viewpoint_in_vehicle);
  trial.error_m = error.norm();
  trial.chi_squared = error.dot(head.front_covariance_m2.ldlt().solve(error));
  trial.centre_error_m = (head.centre - truth.centre).norm();
  trial.foremost_error_m = (foremost_of(head.centre, head.vehicle_from_head, head.semi_axes_m) -
                            foremost_of(truth.centre, truth.vehicle_from_head.toRotationMatrix(), truth.semi_axes))
                               .norm();
  return trial;
}

void print_errors(const char* what, std::vector<double>& errors_m) {
  std::printf("  %-36s %7.1f mm  median, 95 %% within %.1f mm\n", what, 1e3 * median(errors_m),
              1e3 * quantile(errors_m, 0.95));
}

struct Group {
  const char* name;
  std::vector<CabinClass> classes;
  bool to_be_found = false;  // else not to be told is as right as to be told rightly
};

const char* name_of(CockpitGenerator generator) {
  return generator == CockpitGenerator::kTraining ? "training" : "held-out";
}

std::vector<Trial> trials_of(CockpitGenerator generator, const Group& group, int scenes, std::uint64_t seed,
                             ImageSize size) {
  std::vector<Trial> trials(group.classes.size() * static_cast<std::size_t>(scenes));
  for_each_index(trials.size(), kThreads, [&](std::size_t i) {
    trials[i] = trial(generator, group.classes[i % group.classes.size()], seed + i, size);
  });
  return trials;
}

void inform(CockpitGenerator generator, const Group& group, int scenes, std::uint64_t seed, ImageSize size) {
  const std::vector<Trial> trials = trials_of(generator, group, scenes, seed, size);
  std::vector<double> errors_m;
  for (const Trial& trial : trials) {
    if (trial.found) errors_m.push_back(trial.error_m);
  }
  std::printf("information: %s, %s, %dx%d: %zu of %zu found\n", name_of(generator), group.name, size.width, size.height,
              errors_m.size(), trials.size());
  if (!errors_m.empty()) print_errors("of their front", errors_m);
  std::fflush(stdout);
}

bool prove(CockpitGenerator generator, const Group& group, int scenes, std::uint64_t seed) {
  const std::vector<Trial> trials = trials_of(generator, group, scenes, seed, kSize);
  int visible = 0, visible_found = 0, empty = 0, wrong = 0;
  double within[3] = {};
  std::vector<double> errors_m, centre_errors_m, foremost_errors_m;
  for (const Trial& trial : trials) {
    visible += trial.visible;
    visible_found += trial.visible && trial.found;
    empty += !trial.there;
    wrong += !trial.there && trial.found;
    if (!trial.there || !trial.found) continue;
    errors_m.push_back(trial.error_m);
    centre_errors_m.push_back(trial.centre_error_m);
    foremost_errors_m.push_back(trial.foremost_error_m);
    for (int i = 0; i < 3; ++i) within[i] += trial.chi_squared <= kChiSquared[i];
  }
  std::printf("%s, %s: %zu scenes, one frame of %dx%d each\n", name_of(generator), group.name, trials.size(),
              kSize.width, kSize.height);
  bool good = true;
  if (group.to_be_found) {
    good &= at_least(kLeastFound, "heads that are seen well and found", 1.0 * visible_found / std::max(1, visible),
                     kPercent);
  } else if (visible > 0) {
    std::printf("  information: %d of %d heads that are seen well are told\n", visible_found, visible);
  }
  if (empty > 0) {
    const double share = 1.0 * wrong / empty;
    good &= at_most(kMostFalse, "heads found where none is", share, kPercent);
    std::printf("  information: %d of %d; with 95 %% confidence %.1f to %.1f %%\n", wrong, empty,
                100.0 * wilson_bound(share, empty, -1.96), 100.0 * wilson_bound(share, empty, 1.96));
  }
  if (!errors_m.empty()) {
    if (group.to_be_found) {
      good &= at_most(kMostMedian_m, "distance from the true front, median", median(errors_m), kMillimetres);
    }
    good &= at_most(kMost95_m, "95 % quantile", quantile(errors_m, 0.95), kMillimetres);
    for (int i = 0; i < 3; ++i) {
      const std::string what = "within " + std::to_string(i + 1) + " of its sigmas";
      good &= at_least(kLeastWithin[i], what.c_str(), within[i] / static_cast<double>(errors_m.size()), kPercent);
    }
    print_errors("of its centre", centre_errors_m);
    print_errors("of its foremost place", foremost_errors_m);
  }
  std::fflush(stdout);
  return good;
}

}  // namespace

int main(int argc, char** argv) {
  const int scenes = argc > 1 ? std::atoi(argv[1]) : 60;
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : kSeed;
  if (scenes < 1) {
    std::fprintf(stderr, "usage: prove_head [scenes of each class, at least 1 [first seed]]\n");
    return 2;
  }
  const Group groups[] = {
      {"people on the seat", {CabinClass::kPassenger, CabinClass::kOutOfPosition, CabinClass::kChildInBooster}, true},
      {"baby seats", {CabinClass::kForwardBabySeat, CabinClass::kRearBabySeat}},
      {"nobody", {CabinClass::kEmpty, CabinClass::kEmptyBooster, CabinClass::kObjects}}};
  bool good = true;
  for (const CockpitGenerator generator : {CockpitGenerator::kTraining, CockpitGenerator::kTest}) {
    for (const Group& group : groups) good &= prove(generator, group, scenes, seed);
    for (const ImageSize size : {ImageSize{320, 240}, ImageSize{128, 128}}) {
      inform(generator, groups[0], std::max(1, scenes / 3), seed, size);
    }
  }
  return good ? 0 : 1;
}
