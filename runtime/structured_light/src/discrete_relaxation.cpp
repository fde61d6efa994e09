// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "label_rules.hpp"

namespace raybundle {
namespace {

constexpr int kMostRounds = 32;

// Weight of each living candidate, and the two largest of each beam.
void weigh(const LabelTask& task, LabelWork& work) {
  const auto all = task.candidates.all();
  constexpr double kNone = -1e9;
  work.weight.assign(all.size(), kNone);
  work.best_of_beam.assign(task.lattice.row.size(), {kNone, kNone});
  for (std::size_t c = 0; c < all.size(); ++c) {
    if (!work.alive[c] || work.chosen[all[c].dot] >= 0) continue;
    work.weight[c] = weight_of(task, work, all[c]);
    auto& [best, second] = work.best_of_beam[all[c].beam];
    if (work.weight[c] > best) {
      second = best;
      best = work.weight[c];
    } else {
      second = std::max(second, work.weight[c]);
    }
  }
}

// Chooses every candidate that outdoes all living rivals of its dot and its beam; whether there was any.
bool confirm(const LabelTask& task, LabelWork& work) {
  weigh(task, work);
  bool any = false;
  for (int dot = 0; dot < task.candidates.dots(); ++dot) {
    if (work.chosen[dot] >= 0) continue;
    const int begin = task.candidates.first_of_dot(dot);
    const int end = task.candidates.first_of_dot(dot + 1);
    int best = -1;
    double second = -1e9;
    for (int c = begin; c < end; ++c) {
      if (!work.alive[c]) continue;
      if (best < 0 || work.weight[c] > work.weight[best]) {
        if (best >= 0) second = work.weight[best];
        best = c;
      } else {
        second = std::max(second, work.weight[c]);
      }
    }
    if (best < 0) continue;
    const auto& [of_beam, rival_of_beam] = work.best_of_beam[task.candidates.all()[best].beam];
    const double rival = std::max({second, rival_of_beam, of_beam > work.weight[best] ? of_beam : second});
    if (work.weight[best] < rival + kSureBy) continue;
    choose(task, work, best);
    any = true;
  }
  return any;
}

}  // namespace

void discrete_relaxation(const LabelTask& task, LabelWork& work) {
  begin(task, work);
  for (int round = 0; round < kMostRounds && confirm(task, work); ++round) rule_out(task, work);
  withdraw_doubtful(task, work);
}

}  // namespace raybundle
