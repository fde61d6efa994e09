// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "label_rules.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raybundle {
namespace {

constexpr double kSlope = 1.0;              // of surfaces across the line of sight: 45 degrees
constexpr double kEdgeShare = 0.1;          // of neighbouring dots that lie on different surfaces
constexpr std::size_t kMostSupporters = 3;  // neighbours that are not on one surface say little more

// The next label on one side along a row or column; -1 when there is none.
int next_label(const LabelTask& task, const LabelWork& work, int beam, int row_step, int column_step) {
  const BeamLattice& lattice = task.lattice;
  int row = lattice.row[beam] + row_step, column = lattice.column[beam] + column_step;
  for (; row >= 0 && row < lattice.rows && column >= 0 && column < lattice.columns;
       row += row_step, column += column_step) {
    const int other = lattice.at(row, column);
    if (other >= 0 && work.dot_of_beam[other] >= 0) return work.chosen[work.dot_of_beam[other]];
  }
  return -1;
}

bool breaks_order(const LabelTask& task, const LabelWork& work, const Candidate& candidate) {
  for (const auto& [row_step, column_step] : {std::pair{0, 1}, {0, -1}, {1, 0}, {-1, 0}}) {
    const int other = next_label(task, work, candidate.beam, row_step, column_step);
    if (other >= 0 && !in_order(task, candidate, task.candidates.all()[other])) return true;
  }
  return false;
}

}  // namespace

SurfaceFit surface_fit(const SensorRange& range, const Candidate& a, const Candidate& b, double angle_rad) {
  // A surface that slopes changes its inverse distance, from beam to beam, by slope times angle times itself.
  const double middle = std::max(1.0 / range.farthest_m, 0.5 * (a.inverse_distance + b.inverse_distance));
  const double spread = kSlope * angle_rad * middle;
  return {std::abs(a.inverse_distance - b.inverse_distance) / spread, spread};
}

double smoothness(const SensorRange& range, const SurfaceFit& fit) {
  const double width = 1.0 / range.nearest_m - 1.0 / range.farthest_m;
  const double on_one = std::exp(-fit.misfit) * width / (2.0 * fit.spread);
  return std::log((1.0 - kEdgeShare) * on_one + kEdgeShare);
}

double support_by_neighbours(const LabelTask& task, const LabelWork& work, const Candidate& candidate) {
  std::array<SurfaceFit, kMostSupporters> best;  // the best fitting first
  best.fill({std::numeric_limits<double>::infinity(), 1.0});
  for (std::size_t k = 0; k < 8; ++k) {
    const int beam = task.lattice.around[candidate.beam][k];
    if (beam < 0 || work.dot_of_beam[beam] < 0 || work.dot_of_beam[beam] == candidate.dot) continue;
    const Candidate& other = task.candidates.all()[work.chosen[work.dot_of_beam[beam]]];
    SurfaceFit fit = surface_fit(task.range, candidate, other, task.lattice.angle[candidate.beam][k]);
    for (SurfaceFit& better : best) {
      if (fit.misfit < better.misfit) std::swap(fit, better);
    }
  }
  double support = 0.0;
  for (const SurfaceFit& fit : best) {
    if (std::isfinite(fit.misfit)) support += smoothness(task.range, fit);
  }
  return support;
}

void begin(const LabelTask& task, LabelWork& work) {
  work.chosen.assign(task.candidates.dots(), -1);
  work.dot_of_beam.assign(task.lattice.row.size(), -1);
  work.alive.assign(task.candidates.all().size(), 1);
}

void choose(const LabelTask& task, LabelWork& work, int candidate) {
  const Candidate& label = task.candidates.all()[candidate];
  work.chosen[label.dot] = candidate;
  work.dot_of_beam[label.beam] = label.dot;
}

void withdraw(const LabelTask& task, LabelWork& work, int dot) {
  work.dot_of_beam[task.candidates.all()[work.chosen[dot]].beam] = -1;
  work.chosen[dot] = -1;
}

void index_by_beam(const LabelTask& task, LabelWork& work) {
  const auto all = task.candidates.all();
  work.first_of_beam.assign(task.lattice.row.size() + 1, 0);
  for (const Candidate& candidate : all) ++work.first_of_beam[candidate.beam + 1];
  for (std::size_t b = 1; b < work.first_of_beam.size(); ++b) work.first_of_beam[b] += work.first_of_beam[b - 1];
  work.of_beam.resize(all.size());
  for (int c = static_cast<int>(all.size()) - 1; c >= 0; --c) {
    work.of_beam[--work.first_of_beam[all[c].beam + 1]] = c;
  }
  for (std::size_t b = 0; b + 1 < work.first_of_beam.size(); ++b) work.first_of_beam[b] = work.first_of_beam[b + 1];
  work.first_of_beam.back() = static_cast<int>(all.size());
}

void choose_unrivalled(const LabelTask& task, LabelWork& work) {
  for (int dot = 0; dot < task.candidates.dots(); ++dot) {
    if (task.candidates.of_dot(dot).size() != 1) continue;
    const int beam = task.candidates.of_dot(dot)[0].beam;
    const bool alone = work.first_of_beam[beam + 1] - work.first_of_beam[beam] == 1;
    if (alone) choose(task, work, task.candidates.first_of_dot(dot));
  }
}

void rule_out(const LabelTask& task, LabelWork& work) {
  const auto all = task.candidates.all();
  const BeamLattice& lattice = task.lattice;
  for (int dot = 0; dot < task.candidates.dots(); ++dot) {
    if (work.chosen[dot] >= 0) continue;
    const int begin = task.candidates.first_of_dot(dot);
    const int end = task.candidates.first_of_dot(dot + 1);
    for (int c = begin; c < end; ++c) {
      if (!work.alive[c]) continue;
      const Candidate& candidate = all[c];
      const auto breaks = [&](int beam) {
        return beam >= 0 && work.dot_of_beam[beam] >= 0 &&
               !in_order(task, candidate, all[work.chosen[work.dot_of_beam[beam]]]);
      };
      bool dead = work.dot_of_beam[candidate.beam] >= 0;
      const int row = lattice.row[candidate.beam], column = lattice.column[candidate.beam];
      for (int k = 0; k < lattice.columns && !dead; ++k) dead = k != column && breaks(lattice.at(row, k));
      for (int k = 0; k < lattice.rows && !dead; ++k) dead = k != row && breaks(lattice.at(k, column));
      work.alive[c] = !dead;
    }
  }
}

void withdraw_doubtful(const LabelTask& task, LabelWork& work) {
  work.doubtful.clear();
  for (int dot = 0; dot < task.candidates.dots(); ++dot) {
    if (work.chosen[dot] < 0) continue;
    const Candidate& label = task.candidates.all()[work.chosen[dot]];
    const double support = support_by_neighbours(task, work, label);
    const bool by_chance = kBeamOverClutter + label.log_odds + support < 0.0;
    const bool out_of_order = support <= 0.0 && breaks_order(task, work, label);
    if (!label.measures || by_chance || out_of_order) work.doubtful.push_back(dot);
  }
  for (const int dot : work.doubtful) withdraw(task, work, dot);
}

}  // namespace raybundle
