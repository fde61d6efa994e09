// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Starts that never fail: random rigs of every camera model are calibrated from their observations alone. Each must
// reach the optimum that a start from the truth reaches (cost within 1e-6), or be refused where the truth's covariance
// leaves the projection open by more than 1 % of the image.
// usage: prove_starts [model or all] [rigs of each model] [first seed]
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

#include "start_verdict.hpp"

namespace {

using namespace raybundle;
using namespace raybundle::bench;

constexpr std::array kWords{"reached", "refused rightly", "ELSEWHERE", "REFUSED WRONGLY", "UNDETERMINED, ANSWERED"};

struct Tally {
  std::array<int, kWords.size()> of_verdict{};
  std::vector<double> seconds;
  int beyond_5_sigma = 0;

  int failures() const { return of_verdict[2] + of_verdict[3] + of_verdict[4]; }
};

Tally prove(ModelId model, int count, int first_seed) {
  Tally tally;
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
  }
  std::ranges::sort(tally.seconds);
  return tally;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string wanted = argc > 1 ? argv[1] : "all";
  const int count = argc > 2 ? std::max(1, std::atoi(argv[2])) : 1000;
  const int first_seed = argc > 3 ? std::atoi(argv[3]) : 0;
  if (wanted != "all" && !model_named(wanted)) {
    std::fprintf(stderr, "there is no camera model %s\n", wanted.c_str());
    return 2;
  }
  std::vector<std::pair<std::string, Tally>> tallies;
  for (const std::string_view model : model_names()) {
    if (wanted != "all" && wanted != model) continue;
    tallies.emplace_back(model, prove(*model_named(model), count, first_seed));
  }
  std::printf("%-18s %6s %8s %8s %9s %8s %8s %9s %9s\n", "model", "rigs", "reached", "refused", "elsewhere", "wrongly",
              "undeterm", ">5 sigma", "median ms");
  int failures = 0;
  for (const auto& [name, tally] : tallies) {
    const auto& n = tally.of_verdict;
    std::printf("%-18s %6d %8d %8d %9d %8d %8d %9d %9.1f\n", name.c_str(), count, n[0], n[1], n[2], n[3], n[4],
                tally.beyond_5_sigma, 1e3 * tally.seconds[tally.seconds.size() / 2]);
    failures += tally.failures();
  }
  std::printf("%d failures; the bar is 0\n", failures);
  return failures == 0 ? 0 : 1;
}
