// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/case_base.hpp"

#include <algorithm>
#include <cmath>

#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

struct Near {
  float squared = 0.0F;
  int index = -1;
};

using NearCases = std::array<Near, kMostNeighbours>;

// The k nearest of the base's cases, nearest first; of two at the same distance the earlier one.
int nearest_cases(const CaseSpace& space, int neighbours, const float* query, int left_out, NearCases& nearest) {
  const Eigen::Index size = space.cases.rows();
  int found = 0;
  for (int n = 0; n < space.cases.cols(); ++n) {
    if (n == left_out) continue;
    const float* one = space.cases.data() + n * size;
    const float bound = found < neighbours ? INFINITY : nearest[found - 1].squared;
    float squared = 0.0F;
    for (Eigen::Index i = 0; i < size && squared < bound; ++i) {
      const float difference = one[i] - query[i];
      squared += difference * difference;
    }
    if (!(squared < bound)) continue;
    if (found < neighbours) ++found;
    int at = found - 1;
    for (; at > 0 && nearest[at - 1].squared > squared; --at) nearest[at] = nearest[at - 1];
    nearest[at] = {squared, n};
  }
  return found;
}

// Adds what one space says; whether it is near enough to that space's cases.
bool add_votes(const CaseBase& base, const CaseSpace& space, const float* query, int left_out, CaseVerdict& verdict) {
  NearCases nearest;
  const int found = nearest_cases(space, base.neighbours, query, left_out, nearest);
  std::array<double, kMostNeighbours> votes{};
  double sum = 0.0, distance = 0.0;
  for (int i = 0; i < found; ++i) {
    const double away = std::sqrt(static_cast<double>(nearest[i].squared));
    distance += away / found;
    votes[i] = 1.0 / (away + 1e-6);
    sum += votes[i];
  }
  const auto spaces = static_cast<double>(base.spaces.size());
  std::array<double, kAirbagActions> actions{};
  for (int i = 0; i < found; ++i) {
    verdict.votes[base.classes[nearest[i].index]] += votes[i] / sum / spaces;
    actions[static_cast<std::size_t>(base.actions[nearest[i].index])] += votes[i] / sum;
  }
  double allowed = 0.0;
  for (int action = kAirbagActions - 1; action >= 0; --action) {
    allowed += actions[action];
    verdict.action_votes[action] += actions[action] / spaces;
    verdict.allowed_least[action] = std::min(verdict.allowed_least[action], allowed);
  }
  verdict.distance += distance / space.farthest / spaces;
  return distance <= space.farthest;
}

// place_in gives the query's place in a space.
template <typename PlaceIn>
CaseVerdict verdict_of(const CaseBase& base, int left_out, const PlaceIn& place_in) {
  CaseVerdict verdict;
  verdict.allowed_least.fill(1.0);
  verdict.known = true;
  for (const CaseSpace& space : base.spaces) {
    verdict.known &= add_votes(base, space, place_in(space), left_out, verdict);
  }
  verdict.best = static_cast<int>(std::ranges::max_element(verdict.votes) - verdict.votes.begin());
  return verdict;
}

}  // namespace

void CaseBase::check(const std::string& where) const {
  const auto refuse = [&](const std::string& what) {
    throw Error(ErrorKind::kBadInput, "the base of learnt cases is damaged: " + what + "; learn it again", where);
  };
  if (situations.empty() || situations.size() > kMostClasses || group_names.size() > kMostClasses) {
    refuse("it has no classes, or too many");
  }
  if (spaces.empty() || spaces.size() > kMostSpaces) refuse("it has no spaces, or too many");
  for (const CaseSpace& space : spaces) {
    space.embedding.check(where);
    if (space.embedding.attributes() != spaces.front().embedding.attributes())
      refuse("its spaces differ in attributes");
    if (space.cases.rows() != space.embedding.size()) refuse("its cases and its embedding differ in size");
    if (space.cases.cols() != static_cast<Eigen::Index>(classes.size())) refuse("not every case has a class");
    if (!space.cases.allFinite() || !(space.farthest > 0.0) || !std::isfinite(space.farthest)) {
      refuse("it holds a number that is not finite");
    }
  }
  if (actions.size() != classes.size()) refuse("not every case has an action");
  if (neighbours < 1 || neighbours > kMostNeighbours || static_cast<int>(classes.size()) <= neighbours) {
    refuse("it has fewer cases than neighbours");
  }
  for (const double sure : {sure_of_group, sure_of_situation}) {
    if (!(sure >= 0.0 && sure <= 1.0)) refuse("a share of votes is not between 0 and 1");
  }
  for (const SituationClass& situation : situations) {
    if (situation.group < 0 || situation.group >= static_cast<int>(group_names.size())) refuse("a class has no group");
  }
  for (const AirbagAction action : actions) {
    if (action == AirbagAction::kUndecided || action > AirbagAction::kFire) refuse("a case has no right action");
  }
  for (const std::uint8_t c : classes) {
    if (c >= situations.size()) refuse("a case is of a class without a name");
  }
}

CaseVerdict classify(const CaseBase& base, const Eigen::Ref<const Eigen::VectorXd>& attributes) {
  if (!attributes.allFinite()) return {};
  EmbeddedPlace place;
  return verdict_of(base, -1, [&](const CaseSpace& space) {
    place = space.embedding.place(attributes);
    return place.data();
  });
}

CaseVerdict classify_left_out(const CaseBase& base, int index) {
  return verdict_of(base, index, [&](const CaseSpace& space) { return space.cases.col(index).data(); });
}

double distance_to_others(const CaseBase& base, const CaseSpace& space, int index) {
  NearCases nearest;
  const int found =
      nearest_cases(space, base.neighbours, space.cases.data() + index * space.cases.rows(), index, nearest);
  double sum = 0.0;
  for (int i = 0; i < found; ++i) sum += std::sqrt(static_cast<double>(nearest[i].squared));
  return sum / found;
}

std::array<double, kMostClasses> group_votes(const CaseBase& base, const std::array<double, kMostClasses>& votes) {
  std::array<double, kMostClasses> groups{};
  for (std::size_t c = 0; c < base.situations.size(); ++c) groups[base.situations[c].group] += votes[c];
  return groups;
}

}  // namespace raybundle
