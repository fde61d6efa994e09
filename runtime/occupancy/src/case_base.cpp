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
int nearest_cases(const CaseBase& base, const float* query, int left_out, NearCases& nearest) {
  const Eigen::Index size = base.cases.rows();
  int found = 0;
  for (int n = 0; n < base.cases.cols(); ++n) {
    if (n == left_out) continue;
    const float* one = base.cases.data() + n * size;
    const float bound = found < base.neighbours ? INFINITY : nearest[found - 1].squared;
    float squared = 0.0F;
    for (Eigen::Index i = 0; i < size && squared < bound; ++i) {
      const float difference = one[i] - query[i];
      squared += difference * difference;
    }
    if (!(squared < bound)) continue;
    if (found < base.neighbours) ++found;
    int at = found - 1;
    for (; at > 0 && nearest[at - 1].squared > squared; --at) nearest[at] = nearest[at - 1];
    nearest[at] = {squared, n};
  }
  return found;
}

CaseVerdict verdict_of(const CaseBase& base, const float* query, int left_out) {
  CaseVerdict verdict;
  NearCases nearest;
  const int found = nearest_cases(base, query, left_out, nearest);
  if (found < base.neighbours) return verdict;
  double sum = 0.0;
  for (int i = 0; i < found; ++i) {
    const double distance = std::sqrt(static_cast<double>(nearest[i].squared));
    const double vote = 1.0 / (distance + 1e-6);
    verdict.distance += distance / found;
    verdict.votes[base.classes[nearest[i].index]] += vote;
    verdict.action_votes[static_cast<std::size_t>(base.actions[nearest[i].index])] += vote;
    sum += vote;
  }
  for (double& vote : verdict.votes) vote /= sum;
  for (double& vote : verdict.action_votes) vote /= sum;
  verdict.best = static_cast<int>(std::ranges::max_element(verdict.votes) - verdict.votes.begin());
  verdict.known = verdict.distance <= base.farthest;
  return verdict;
}

[[noreturn]] void refuse(const std::string& what) {
  throw Error(ErrorKind::kBadInput, "the base of learnt cases is damaged: " + what + "; learn it again");
}

}  // namespace

void CaseBase::check() const {
  if (situations.empty() || situations.size() > kMostClasses || group_names.size() > kMostClasses) {
    refuse("it has no classes, or too many");
  }
  embedding.check();
  if (cases.rows() != embedding.size()) refuse("its cases and its embedding differ in size");
  if (cases.cols() != static_cast<Eigen::Index>(classes.size()) || actions.size() != classes.size())
    refuse("not every case has a class and an action");
  if (neighbours < 1 || neighbours > kMostNeighbours || cases.cols() <= neighbours) {
    refuse("it has fewer cases than neighbours");
  }
  if (!cases.allFinite() || !std::isfinite(farthest)) {
    refuse("it holds a number that is not finite");
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
  const EmbeddedPlace place = base.embedding.place(attributes);
  return verdict_of(base, place.data(), -1);
}

CaseVerdict classify_left_out(const CaseBase& base, int left_out) {
  return verdict_of(base, base.cases.data() + left_out * base.cases.rows(), left_out);
}

}  // namespace raybundle
