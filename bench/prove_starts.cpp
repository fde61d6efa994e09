// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Starts that never fail: random rigs of every camera model are calibrated from their observations alone. Each must
// reach the optimum that a start from the truth reaches (cost within 1e-6), or be refused where the truth's covariance
// leaves the projection open by more than 1 % of the image.
// OpenCV and mrcal stand beside it where they have the model, on the rigs that are determined and without the corners
// that are known to be wrong, which they would not survive; mrcal is given a focal length besides. Their answers count
// as reached when a solve that goes on from them reaches the truth's optimum. usage: prove_starts [model or all] [rigs
// of each model] [first seed] [alone, for no peers]
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include "mrcal_peer.hpp"
#include "opencv_peer.hpp"
#include "start_verdict.hpp"

namespace {

using namespace raybundle;
using namespace raybundle::bench;
using namespace raybundle::testing;

constexpr std::array kWords{"reached", "refused rightly", "ELSEWHERE", "REFUSED WRONGLY", "UNDETERMINED, ANSWERED"};

struct Tally {
  std::array<int, kWords.size()> of_verdict{};
  std::vector<double> seconds;
  int beyond_5_sigma = 0;
  int determined = 0, determined_failed = 0;
  std::optional<int> opencv_failed, mrcal_failed;  // of the determined rigs

  int failures() const { return of_verdict[2] + of_verdict[3] + of_verdict[4]; }
};

// Failures of the peers on rigs that are determined.
void count_peers(const std::vector<RandomRig>& rigs, const std::vector<TruthStart>& truths, Tally& tally) {
  if (rigs.empty()) return;
  const std::string_view model = model_name(rigs.front().problem.cameras[0].model);
  if (opencv_has(model)) {
    int failed = 0;
    for (std::size_t i = 0; i < rigs.size(); ++i) {
      failed += !reaches(rigs[i], truths[i], calibrate_with_opencv(rigs[i], true));
    }
    tally.opencv_failed = failed;
  }
  if (mrcal_has(model) && mrcal_is_there()) {
    const std::vector<std::optional<BundleState>> answers = calibrate_with_mrcal(rigs);
    int failed = 0;
    for (std::size_t i = 0; i < rigs.size(); ++i) failed += !reaches(rigs[i], truths[i], answers[i]);
    tally.mrcal_failed = failed;
  }
}

std::string share(const std::optional<int>& failed, int of) {
  if (!failed || of == 0) return "-";
  return fmt::format("{:.1f} %", 100.0 * *failed / of);
}

Tally prove(ModelId model, int count, int first_seed, bool with_peers) {
  Tally tally;
  std::vector<RandomRig> determined;
  std::vector<TruthStart> truths;
  const std::string name(model_name(model));
  for (int seed = first_seed; seed < first_seed + count; ++seed) {
    const RandomRig rig = random_rig(model, static_cast<std::uint64_t>(seed));
    const TruthStart truth = start_from_truth(rig);
    const Judgement judgement = judge_start(rig, truth);
    const auto verdict = static_cast<std::size_t>(judgement.verdict);
    ++tally.of_verdict[verdict];
    tally.seconds.push_back(judgement.seconds);
    tally.beyond_5_sigma += judgement.verdict == Verdict::kReached && judgement.error_sigmas > 5.0;
    if (judgement.failed() || count == 1) {
      std::printf("  %s %d: %s: %s\n    %s; projection known to %.3g px\n", name.c_str(), seed, kWords[verdict],
                  judgement.why.c_str(), rig.story.c_str(), truth.projection_sigma_px);
      std::fflush(stdout);
    }
    if (!truth.determined) continue;
    ++tally.determined;
    tally.determined_failed += judgement.failed();
    if (!with_peers) continue;
    determined.push_back(rig);
    truths.push_back(truth);
  }
  count_peers(determined, truths, tally);
  std::ranges::sort(tally.seconds);
  return tally;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string wanted = argc > 1 ? argv[1] : "all";
  const int count = argc > 2 ? std::max(1, std::atoi(argv[2])) : 1000;
  const int first_seed = argc > 3 ? std::atoi(argv[3]) : 0;
  const bool with_peers = argc <= 4;
  if (wanted != "all" && !model_named(wanted)) {
    std::fprintf(stderr, "there is no camera model %s\n", wanted.c_str());
    return 2;
  }
  std::vector<std::pair<std::string, Tally>> tallies;
  for (const std::string_view model : model_names()) {
    if (wanted != "all" && wanted != model) continue;
    tallies.emplace_back(model, prove(*model_named(model), count, first_seed, with_peers));
  }
  std::printf("%-18s %6s %8s %8s %9s %8s %8s %9s %9s   of the determined, failed: %8s %8s %8s\n", "model", "rigs",
              "reached", "refused", "elsewhere", "wrongly", "undeterm", ">5 sigma", "median ms", "ours", "OpenCV",
              "mrcal");
  int failures = 0;
  for (const auto& [name, tally] : tallies) {
    const auto& n = tally.of_verdict;
    std::printf("%-18s %6d %8d %8d %9d %8d %8d %9d %9.1f   %26d %8s %8s %8s\n", name.c_str(), count, n[0], n[1], n[2],
                n[3], n[4], tally.beyond_5_sigma, 1e3 * tally.seconds[tally.seconds.size() / 2], tally.determined,
                share(tally.determined_failed, tally.determined).c_str(),
                share(tally.opencv_failed, tally.determined).c_str(),
                share(tally.mrcal_failed, tally.determined).c_str());
    failures += tally.failures();
  }
  std::printf("%d failures; the bar is 0\n", failures);
  return failures == 0 ? 0 : 1;
}
