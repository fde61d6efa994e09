// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "raybundle/structured_light/candidates.hpp"

namespace raybundle {

/// How the beams lie beside each other on their grid.
struct BeamLattice {
  explicit BeamLattice(const SensorTable& table);

  int at(int row, int column) const { return beam_at[static_cast<std::size_t>(row) * columns + column]; }

  int rows = 0, columns = 0;
  std::vector<int> beam_at;                  ///< by row and column; -1 where there is no beam
  std::vector<std::array<int, 8>> around;    ///< neighbours of each beam; -1 where there is none
  std::vector<std::array<double, 8>> angle;  ///< to them [rad]
  std::vector<int> row, column;              ///< of each beam
  std::vector<Eigen::Vector3d> direction;    ///< of each beam
};

/// What is to be labelled.
struct LabelTask {
  const BeamLattice& lattice;
  const SensorRange& range;
  const Candidates& candidates;
};

/// Memory of the labellers, taken once.
struct LabelWork {
  LabelWork(int most_dots, const SensorTable& table);

  std::vector<int> chosen;                          ///< of each dot: index of its candidate, or -1
  std::vector<int> dot_of_beam;                     ///< -1: none
  std::vector<char> alive;                          ///< of each candidate
  std::vector<double> weight, next_weight;          ///< of each candidate
  std::vector<double> no_beam;                      ///< weight that a dot is of none
  std::vector<std::array<double, 2>> best_of_beam;  ///< the two largest weights
  std::vector<int> doubtful;                        ///< dots
  std::vector<int> first_of_beam, of_beam;          ///< candidates beam by beam
  std::vector<int> group, member;                   ///< dots that are linked by common beams
};

/// Chooses for each dot one of its candidates, or none. Writes LabelWork::chosen. A dot that it is not sure of stays
/// without: unlabelled is an answer, a guess is none.
struct Labeller {
  std::string_view name;
  std::string_view what;
  void (*label)(const LabelTask& task, LabelWork& work);
};

/// Source of all but the last: Lerasle, Lequellec, Devy 2000, Relaxation vs Maximal Cliques Search for Projected Beams
/// Labeling in a Structured Light Sensor.
void discrete_relaxation(const LabelTask& task, LabelWork& work);
void continuous_relaxation(const LabelTask& task, LabelWork& work);
void maximal_cliques(const LabelTask& task, LabelWork& work);
void maximum_set(const LabelTask& task, LabelWork& work);

/// The one list of labellers; the first is the usual one.
inline constexpr std::array kLabellers{
    Labeller{"discrete", "confident labels rule out others, round by round", discrete_relaxation},
    Labeller{"continuous", "the probabilities of labels support each other", continuous_relaxation},
    Labeller{"cliques", "the largest set of labels that exclude none of each other", maximal_cliques},
    Labeller{"exact", "the set of the largest weight, by branch and bound", maximum_set},
};

/// Whether two labels keep the order of their beams in the grid: of the same row or column, the dots must lie to each
/// other as the beams do. Always true for beams of different rows and columns.
bool in_order(const LabelTask& task, const Candidate& a, const Candidate& b);

/// Takes back the labels that are likelier by chance than of their beam, those out of order that no neighbour bears
/// out, and those that measure nothing. What every labeller ends with.
void withdraw_doubtful(const LabelTask& task, LabelWork& work);

}  // namespace raybundle
