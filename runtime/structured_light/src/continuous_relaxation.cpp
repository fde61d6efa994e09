// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "label_rules.hpp"

namespace raybundle {
namespace {

constexpr int kRounds = 12;
constexpr double kNoBeam = 1e-3;    // probability that a dot is of no beam, beside one on a curve
constexpr double kSure = 0.99;      // of a label that is kept
constexpr double kMostSupport = 4;  // [log-odds] of one neighbour

// How much the neighbours' present probabilities speak for a candidate [log-odds]: those that fit, beam by beam.
double mean_support(const LabelTask& task, const LabelWork& work, const Candidate& candidate) {
  const auto all = task.candidates.all();
  double support = 0.0;
  for (std::size_t n = 0; n < 8; ++n) {
    const int beam = task.lattice.around[candidate.beam][n];
    if (beam < 0) continue;
    const double angle = task.lattice.angle[candidate.beam][n];
    for (int k = work.first_of_beam[beam]; k < work.first_of_beam[beam + 1]; ++k) {
      const Candidate& other = all[work.of_beam[k]];
      if (other.dot == candidate.dot) continue;
      const double order = in_order(task, candidate, other) ? 0.0 : -kMostSupport;
      support += work.weight[work.of_beam[k]] *
                 (smoothness(task.range, surface_fit(task.range, candidate, other, angle)) + order);
    }
  }
  return std::clamp(support, -2.0 * kMostSupport, 2.0 * kMostSupport);
}

// The other dots' claims on the same beam: 1 when none has any.
double free_share(const LabelTask& task, const LabelWork& work, const Candidate& candidate) {
  double free = 1.0;
  for (int k = work.first_of_beam[candidate.beam]; k < work.first_of_beam[candidate.beam + 1]; ++k) {
    const int other = work.of_beam[k];
    if (task.candidates.all()[other].dot != candidate.dot) free *= 1.0 - work.weight[other];
  }
  return free;
}

void start(const LabelTask& task, LabelWork& work) {
  const auto all = task.candidates.all();
  work.weight.resize(all.size());
  work.next_weight.resize(all.size());
  for (int dot = 0; dot < task.candidates.dots(); ++dot) {
    const int begin = task.candidates.first_of_dot(dot), end = task.candidates.first_of_dot(dot + 1);
    double sum = kNoBeam;
    for (int c = begin; c < end; ++c) sum += std::exp(all[c].log_odds);
    for (int c = begin; c < end; ++c) work.weight[c] = std::exp(all[c].log_odds) / sum;
  }
}

// All probabilities from those of the round before.
void relax(const LabelTask& task, LabelWork& work) {
  const auto all = task.candidates.all();
  for (int dot = 0; dot < task.candidates.dots(); ++dot) {
    const int begin = task.candidates.first_of_dot(dot), end = task.candidates.first_of_dot(dot + 1);
    double sum = kNoBeam;
    for (int c = begin; c < end; ++c) {
      const double likelihood = std::exp(all[c].log_odds);
      work.next_weight[c] = likelihood * free_share(task, work, all[c]) * std::exp(mean_support(task, work, all[c]));
      sum += work.next_weight[c];
    }
    for (int c = begin; c < end; ++c) work.next_weight[c] /= sum;
  }
  std::swap(work.weight, work.next_weight);
}

}  // namespace

void continuous_relaxation(const LabelTask& task, LabelWork& work) {
  begin(task, work);
  index_by_beam(task, work);
  start(task, work);
  for (int round = 0; round < kRounds; ++round) relax(task, work);
  for (std::size_t c = 0; c < work.weight.size(); ++c) {
    const int beam = task.candidates.all()[c].beam;
    if (work.weight[c] > kSure && work.dot_of_beam[beam] < 0) choose(task, work, static_cast<int>(c));
  }
  withdraw_doubtful(task, work);
}

}  // namespace raybundle
