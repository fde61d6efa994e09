// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/learn.hpp"

#include <algorithm>
#include <utility>

#include "embedding_search.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

constexpr Eigen::Index kAsked = 4000;  // cases whose distances to the others set what is near

void check(const LabelledCases& cases, const LearnOptions& options) {
  if (cases.attributes.cols() != static_cast<Eigen::Index>(cases.classes.size()) ||
      cases.actions.size() != cases.classes.size() || cases.attributes.rows() < 1 ||
      cases.situations.size() > kMostClasses) {
    throw Error(ErrorKind::kBadInput, "attributes and classes of the cases to learn differ in number");
  }
  if (!cases.attributes.allFinite()) throw Error(ErrorKind::kBadInput, "an attribute to learn is not finite");
  for (std::size_t c = 0; c < cases.situations.size(); ++c) {
    const auto count = std::ranges::count(cases.classes, static_cast<std::uint8_t>(c));
    if (count <= options.neighbours) {
      throw Error(ErrorKind::kNotEnoughData, "class '" + cases.situations[c].name + "' has " + std::to_string(count) +
                                                 " cases, and more than " + std::to_string(options.neighbours) +
                                                 " are needed: add scenes of it");
    }
  }
}

// What near cases should have in common: class and right action.
std::vector<int> kinds_of(const LabelledCases& cases) {
  std::vector<int> kinds;
  for (std::size_t n = 0; n < cases.classes.size(); ++n) {
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

}  // namespace

CaseBase learn(const LabelledCases& cases, const LearnOptions& options) {
  check(cases, options);
  const Eigen::MatrixXf attributes = cases.attributes.cast<float>();
  CaseBase base{.attribute_set = cases.attribute_set,
                .situations = cases.situations,
                .group_names = cases.group_names,
                .spaces = {},
                .classes = {},
                .actions = {},
                .neighbours = options.neighbours};
  const Eigen::Index every = 1 + (attributes.cols() - 1) / options.most_cases;
  for (Eigen::Index n = 0; n < attributes.cols(); n += every) {
    base.classes.push_back(cases.classes[n]);
    base.actions.push_back(cases.actions[n]);
  }
  const std::vector<int> kinds = kinds_of(cases);
  EmbeddingSearch search{.sizes = options.layers,
                         .steps = std::min(options.steps, steps_for(attributes.cols())),
                         .decay = options.decay,
                         .dropout = options.dropout};
  for (int s = 0; s < options.spaces; ++s) {
    search.seed = static_cast<std::uint64_t>(s) + 1;
    CaseSpace space{.embedding = embedding_search(attributes, kinds, search), .cases = {}};
    space.cases.resize(space.embedding.size(), static_cast<Eigen::Index>(base.classes.size()));
    for (Eigen::Index n = 0; n < space.cases.cols(); ++n) {
      const EmbeddedPlace place = space.embedding.place(cases.attributes.col(n * every));
      space.cases.col(n) = Eigen::Map<const Eigen::VectorXf>(place.data(), space.embedding.size());
    }
    space.farthest = farthest_known(base, space, options.known_share);
    base.spaces.push_back(std::move(space));
  }
  base.check();
  return base;
}

}  // namespace raybundle
