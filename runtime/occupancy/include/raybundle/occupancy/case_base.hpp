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
inline constexpr int kMostSpaces = 8;

/// What the airbag may do in a crash, from the least forceful. Undecided: whoever asks must fall back on other sensors.
enum class AirbagAction : std::uint8_t { kUndecided, kNoFire, kDepowered, kFire };
inline constexpr int kAirbagActions = 4;

/// What may be on the seat.
struct SituationClass {
  std::string name;
  int group = 0;       ///< index into CaseBase::group_names: the coarse classes
  bool inert = false;  ///< nothing of it moves by itself
};

/// A space in which learnt situations of one class are near to each other.
struct CaseSpace {
  Embedding embedding;    ///< from attributes to the space
  Eigen::MatrixXf cases;  ///< M×N, one column a learnt situation
  double farthest = 0.0;  ///< a situation farther than this from its nearest cases is unknown
};

/// Learnt situations: scenes whose class is known, in several spaces that were learnt apart: where they disagree,
/// nothing is sure. Sizes agree: see check().
struct CaseBase {
  std::string attribute_set;               ///< which function made the attributes: see attributes.hpp
  std::vector<SituationClass> situations;  ///< at most kMostClasses
  std::vector<std::string> group_names;    ///< at most kMostClasses
  std::vector<CaseSpace> spaces;           ///< at most kMostSpaces
  std::vector<std::uint8_t> classes;       ///< N, indices into situations
  std::vector<AirbagAction> actions;       ///< N, what was right for each case
  int neighbours = 7;                      ///< k
  double sure_of_group = 0.5;              ///< votes that a group must have before it is told
  double sure_of_situation = 0.5;          ///< votes that a class must have before it is told

  /// @param where  name of its file, for messages
  /// @throws Error(kBadInput) naming what does not agree
  void check(const std::string& where = {}) const;
};

/// What the nearest cases say; means over the spaces but where it says otherwise.
struct CaseVerdict {
  int best = -1;                                      ///< class with the most votes
  std::array<double, kMostClasses> votes{};           ///< shares, sum 1: the nearer a case the more its vote counts
  std::array<double, kAirbagActions> action_votes{};  ///< shares, sum 1
  std::array<double, kAirbagActions>
      allowed_least{};    ///< votes for this action or a more forceful one: least of any space
  double distance = 0.0;  ///< mean to the k nearest cases, over the farthest known
  bool known = false;     ///< near enough to cases in every space
};

/// The k nearest cases vote. Brute force: bounded, without heap, the same bits on every run.
///
/// @param attributes  as many as the embedding takes
CaseVerdict classify(const CaseBase& base, const Eigen::Ref<const Eigen::VectorXd>& attributes);

/// What the nearest cases say of one of them, itself left out.
CaseVerdict classify_left_out(const CaseBase& base, int index);

/// How far a case is from the k nearest others of its space, on average.
double distance_to_others(const CaseBase& base, const CaseSpace& space, int index);

/// Votes of the groups, from those of the classes.
std::array<double, kMostClasses> group_votes(const CaseBase& base, const std::array<double, kMostClasses>& votes);

}  // namespace raybundle
