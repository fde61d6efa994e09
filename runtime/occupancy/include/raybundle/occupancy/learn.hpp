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
};

struct LearnOptions {
  int neighbours = 25;
  int spaces = 3;                       ///< learnt apart, each from other random numbers
  int most_cases = 24000;               ///< kept, evenly chosen; all are learnt from
  double known_share = 0.999;           ///< of the learnt cases that are near enough to the others: sets `farthest`
  std::vector<int> layers{96, 48, 16};  ///< sizes of the embedding's layers, the last one that of the cases' space
  int steps = 2000;                     ///< of the search for it, at most; fewer for few cases
  double decay = 1e-4;                  ///< how much its weights are drawn to zero
  double dropout = 0.1;                 ///< share of the values between layers that a step leaves out
};

/// Makes a base of cases: an embedding in which neighbours are of one class and of one right action, and the places of
/// all cases in it. Not for the device: it uses the heap.
///
/// @throws Error(kNotEnoughData) when a class has fewer cases than neighbours; Error(kBadInput) when sizes differ
/// Source: embedding_search.hpp
CaseBase learn(const LabelledCases& cases, const LearnOptions& options = {});

}  // namespace raybundle
