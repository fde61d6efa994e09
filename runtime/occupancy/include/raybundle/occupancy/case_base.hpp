// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "raybundle/occupancy/embedding.hpp"

namespace raybundle {

inline constexpr int kMostClasses = 16;
inline constexpr int kMostNeighbours = 32;

/// What the airbag may do in a crash, from the least forceful. Undecided: whoever asks must fall back on other sensors.
enum class AirbagAction : std::uint8_t { kUndecided, kNoFire, kDepowered, kFire };
inline constexpr int kAirbagActions = 4;

/// What may be on the seat.
struct SituationClass {
  std::string name;
  int group = 0;       ///< index into CaseBase::group_names: the coarse classes
  bool inert = false;  ///< nothing of it moves by itself
};

/// Learnt situations: scenes whose class is known, as places in a space in which situations of one class are near to
/// each other. Sizes agree: see check().
struct CaseBase {
  std::string attribute_set;               ///< which function made the attributes: see attributes.hpp
  std::vector<SituationClass> situations;  ///< at most kMostClasses
  std::vector<std::string> group_names;    ///< at most kMostClasses
  Embedding embedding;                     ///< from attributes to the space of the cases
  Eigen::MatrixXf cases;                   ///< M×N, one column a learnt situation
  std::vector<std::uint8_t> classes;       ///< N, indices into situations
  std::vector<AirbagAction> actions;       ///< N, what was right for each case
  int neighbours = 7;                      ///< k
  double farthest = 0.0;                   ///< a situation farther than this from its nearest cases is unknown

  /// @throws Error(kBadInput) naming what does not agree
  void check() const;
};

/// What the nearest cases say.
struct CaseVerdict {
  int best = -1;                                      ///< class with the most votes
  std::array<double, kMostClasses> votes{};           ///< shares, sum 1: the nearer a case the more its vote counts
  std::array<double, kAirbagActions> action_votes{};  ///< shares, sum 1
  double distance = 0.0;                              ///< mean to the k nearest cases
  bool known = false;                                 ///< near enough to cases
};

/// The k nearest cases vote. Brute force: bounded, without heap, the same bits on every run.
///
/// @param attributes  as many as the embedding takes
CaseVerdict classify(const CaseBase& base, const Eigen::Ref<const Eigen::VectorXd>& attributes);

/// As classify, but leaves one case out: how well the base knows its own cases.
CaseVerdict classify_left_out(const CaseBase& base, int left_out);

}  // namespace raybundle
