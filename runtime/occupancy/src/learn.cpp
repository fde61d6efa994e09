// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/learn.hpp"

#include <algorithm>
#include <utility>

#include "embedding_search.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/threads.hpp"
#include "raybundle/geometry/wilson.hpp"

namespace raybundle {
namespace {

constexpr Eigen::Index kAsked = 6000;  // cases that are held against the others to set bounds

int voting_of(const LabelledCases& cases) {
  return cases.voting > 0 ? cases.voting : static_cast<int>(cases.classes.size());
}

void check(const LearnOptions& options) {
  const auto within = [](int value, int least, int most) { return value >= least && value <= most; };
  const bool sizes = within(static_cast<int>(options.layers.size()), 1, kMostLayers) &&
                     std::ranges::all_of(options.layers, [&](int size) { return within(size, 1, kMostUnits); });
  if (!sizes || !within(options.neighbours, 1, kMostNeighbours) || !within(options.spaces, 1, kMostSpaces) ||
      !(options.known_share >= 0.0 && options.known_share <= 1.0) || options.steps < 1 ||
      !(options.dropout >= 0.0 && options.dropout < 1.0)) {
    throw Error(ErrorKind::kBadInput,
                "learning takes 1 to " + std::to_string(kMostNeighbours) + " neighbours, 1 to " +
                    std::to_string(kMostSpaces) + " spaces, 1 to " + std::to_string(kMostLayers) + " layers of 1 to " +
                    std::to_string(kMostUnits) +
                    " values, a known share from 0 to 1, one step or more and a dropout from 0 to below 1");
  }
}

void check_classes(const LabelledCases& cases) {
  for (const SituationClass& situation : cases.situations) {
    if (situation.group < 0 || situation.group >= static_cast<int>(cases.group_names.size())) {
      throw Error(ErrorKind::kBadInput, "class '" + situation.name + "' has no group");
    }
  }
  if (std::ranges::any_of(cases.classes, [&](std::uint8_t c) { return c >= cases.situations.size(); })) {
    throw Error(ErrorKind::kBadInput, "a case to learn is of a class without a name");
  }
}

void check(const LabelledCases& cases, const LearnOptions& options) {
  check(options);
  if (cases.attributes.cols() != static_cast<Eigen::Index>(cases.classes.size()) ||
      cases.actions.size() != cases.classes.size() || cases.attributes.rows() < 1 ||
      cases.attributes.rows() > kMostUnits || cases.situations.size() > kMostClasses ||
      cases.group_names.size() > kMostClasses) {
    throw Error(ErrorKind::kBadInput, "attributes and classes of the cases to learn differ in number, or are too many");
  }
  if (cases.voting < 0 || cases.voting >= static_cast<int>(cases.classes.size()) || cases.judging < 0 ||
      cases.judging > voting_of(cases)) {
    throw Error(ErrorKind::kBadInput, "more of the cases to learn vote or judge than there are");
  }
  check_classes(cases);
  if (!cases.attributes.allFinite()) throw Error(ErrorKind::kBadInput, "an attribute to learn is not finite");
  for (std::size_t c = 0; c < cases.situations.size(); ++c) {
    const auto count =
        std::count(cases.classes.end() - voting_of(cases), cases.classes.end(), static_cast<std::uint8_t>(c));
    if (count <= options.neighbours) {
      throw Error(ErrorKind::kNotEnoughData, "class '" + cases.situations[c].name + "' has " + std::to_string(count) +
                                                 " cases that vote, and more than " +
                                                 std::to_string(options.neighbours) + " are needed: add scenes of it");
    }
  }
}

// What near cases should have in common: class and right action. Of the first cases.
std::vector<int> kinds_of(const LabelledCases& cases, Eigen::Index count) {
  std::vector<int> kinds;
  for (Eigen::Index n = 0; n < count; ++n) {
    kinds.push_back(cases.classes[n] * kAirbagActions + static_cast<int>(cases.actions[n]));
  }
  return kinds;
}

double farthest_known(const CaseBase& base, const CaseSpace& space, double share) {
  const Eigen::Index step = 1 + space.cases.cols() / kAsked;
  std::vector<double> distances;
  for (Eigen::Index n = 0; n < space.cases.cols(); n += step) {
    distances.push_back(distance_to_others(base, space, static_cast<int>(n)));
  }
  std::ranges::sort(distances);
  return distances[static_cast<std::size_t>(share * static_cast<double>(distances.size() - 1))];
}

// Few cases are learnt by heart when they are seen too often.
int steps_for(Eigen::Index cases) {
  constexpr Eigen::Index kPasses = 60, kLeast = 300;
  return static_cast<int>(std::max(kLeast, kPasses * cases / kEmbeddingBatch));
}

CaseSpace space_of(const Eigen::MatrixXf& attributes, const std::vector<int>& kinds,
                   const Eigen::Ref<const Eigen::MatrixXd>& voting, const EmbeddingSearch& search) {
  CaseSpace space{.embedding = embedding_search(attributes, kinds, search), .cases = {}};
  space.cases.resize(space.embedding.size(), voting.cols());
  for (Eigen::Index n = 0; n < voting.cols(); ++n) {
    const EmbeddedPlace place = space.embedding.place(voting.col(n));
    space.cases.col(n) = Eigen::Map<const Eigen::VectorXf>(place.data(), space.embedding.size());
  }
  return space;
}

// An answer, were it told.
struct Told {
  double votes = 0.0;
  bool right = false;
};

template <typename Votes>
Told told(const Votes& votes, int truth) {
  const auto most = std::ranges::max_element(votes);
  return {*most, most - votes.begin() == truth};
}

// The least votes such that of all answers with as many the wanted share is right, at 95 % confidence; 1 when there are
// none: then only what no vote speaks against is told.
double least_sure(std::vector<Told> answers, double wanted) {
  constexpr double kSigmas = -1.645;
  std::ranges::sort(answers, [](const Told& a, const Told& b) { return a.votes > b.votes; });
  double least = 1.0, right = 0.0;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    right += answers[i].right;
    const double count = static_cast<double>(i) + 1.0;
    const bool last_of_its_votes = i + 1 == answers.size() || answers[i + 1].votes < answers[i].votes;
    if (last_of_its_votes && wilson_bound(right / count, count, kSigmas) >= wanted) least = answers[i].votes;
  }
  return least;
}

// Votes that must be had before groups and classes are told, by what the voting cases say of the last of them.
void set_sureness(CaseBase& base, Eigen::Index judging, const LearnOptions& options) {
  const Eigen::Index cases = base.spaces.front().cases.cols(), step = 1 + (judging - 1) / kAsked;
  std::vector<Told> groups, situations;
  for (Eigen::Index n = cases - judging; n < cases; n += step) {
    const CaseVerdict verdict = classify_left_out(base, static_cast<int>(n));
    if (!verdict.known) continue;
    situations.push_back(told(verdict.votes, base.classes[n]));
    groups.push_back(told(group_votes(base, verdict.votes), base.situations[base.classes[n]].group));
  }
  base.sure_of_group = least_sure(std::move(groups), options.right_groups);
  base.sure_of_situation = least_sure(std::move(situations), options.right_situations);
}

}  // namespace

CaseBase learn(const LabelledCases& cases, const LearnOptions& options) {
  check(cases, options);
  const int voting = voting_of(cases);
  const Eigen::Index learnt = cases.attributes.cols() - cases.voting;
  const Eigen::MatrixXf attributes = cases.attributes.leftCols(learnt).cast<float>();
  const std::vector<int> kinds = kinds_of(cases, learnt);
  CaseBase base{.attribute_set = cases.attribute_set,
                .situations = cases.situations,
                .group_names = cases.group_names,
                .spaces = std::vector<CaseSpace>(static_cast<std::size_t>(options.spaces)),
                .classes = {cases.classes.end() - voting, cases.classes.end()},
                .actions = {cases.actions.end() - voting, cases.actions.end()},
                .neighbours = options.neighbours};
  for_each_index(base.spaces.size(), options.threads, [&](std::size_t s) {
    base.spaces[s] = space_of(attributes, kinds, cases.attributes.rightCols(voting),
                              {.sizes = options.layers,
                               .steps = std::min(options.steps, steps_for(learnt)),
                               .decay = options.decay,
                               .dropout = options.dropout,
                               .seed = s + 1});
    base.spaces[s].farthest = farthest_known(base, base.spaces[s], options.known_share);
  });
  set_sureness(base, cases.judging > 0 ? cases.judging : voting, options);
  base.check();
  return base;
}

}  // namespace raybundle
