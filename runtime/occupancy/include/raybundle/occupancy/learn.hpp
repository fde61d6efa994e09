// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "raybundle/occupancy/case_base.hpp"

namespace raybundle {

/// Situations whose class is known.
struct LabelledCases {
  std::string attribute_set;
  std::vector<SituationClass> situations;
  std::vector<std::string> group_names;
  Eigen::MatrixXd attributes;         ///< D×N
  std::vector<std::uint8_t> classes;  ///< N
  std::vector<AirbagAction> actions;  ///< N, what is right for each
  /// The last so many vote, and spaces are learnt from the others: cases that were learnt from lie nearer to their kind
  /// than new ones do, and vote too surely. They must be of other scenes. 0: all are learnt from and vote.
  int voting = 0;
  int judging = 0;  ///< the last so many of those set from which votes on an answer is told; 0: all of them
};

struct LearnOptions {
  int neighbours = 25;
  int spaces = 3;                       ///< learnt apart, each from other random numbers
  double known_share = 0.999;           ///< of the learnt cases that are near enough to the others: sets `farthest`
  std::vector<int> layers{96, 48, 16};  ///< sizes of the embedding's layers, the last one that of the cases' space
  int steps = 30000;                    ///< of the search for it, at most; fewer for few cases
  double decay = 1e-4;                  ///< how much its weights are drawn to zero
  double dropout = 0.1;                 ///< share of the values between layers that a step leaves out
  double right_groups = 0.99;           ///< share of the groups told that must be right: sets `sure_of_group`
  double right_situations = 0.95;       ///< the same for classes
  int threads = 1;                      ///< the base does not depend on them
};

/// Makes a base of cases: spaces in which neighbours are of one class and of one right action, and the places of the
/// voting cases in them. From which votes on an answer is told is set by what they say of each other: the least votes
/// whose answers are right with the wanted share at 95 % confidence. Not for the device: it uses the heap.
///
/// @throws Error(kNotEnoughData) when a class has too few voting cases; Error(kBadInput) when sizes differ
///         or options are out of their ranges
/// Source: embedding_search.hpp
CaseBase learn(const LabelledCases& cases, const LearnOptions& options = {});

}  // namespace raybundle
