// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/learn.hpp"

#include <algorithm>
#include <cmath>

#include "embedding_search.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

constexpr std::size_t kAsked = 4000;  // cases whose distances to the others set what is near

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

}  // namespace

CaseBase learn(const LabelledCases& cases, const LearnOptions& options) {
  check(cases, options);
  const Eigen::MatrixXf attributes = cases.attributes.cast<float>();
  CaseBase base{
      .attribute_set = cases.attribute_set,
      .situations = cases.situations,
      .group_names = cases.group_names,
      .embedding = embedding_search(
          attributes, kinds_of(cases),
          {.sizes = options.layers, .steps = options.steps, .decay = options.decay, .dropout = options.dropout}),
      .cases = {},
      .classes = cases.classes,
      .actions = cases.actions,
      .neighbours = options.neighbours,
      .farthest = 0.0};
  base.cases.resize(base.embedding.size(), attributes.cols());
  for (Eigen::Index n = 0; n < attributes.cols(); ++n) {
    const EmbeddedPlace place = base.embedding.place(cases.attributes.col(n));
    base.cases.col(n) = Eigen::Map<const Eigen::VectorXf>(place.data(), base.embedding.size());
  }

  const std::size_t step = 1 + cases.classes.size() / kAsked;
  std::vector<double> distances;
  for (std::size_t n = 0; n < cases.classes.size(); n += step) {
    distances.push_back(classify_left_out(base, static_cast<int>(n)).distance);
  }
  std::ranges::sort(distances);
  const auto at = static_cast<std::size_t>(options.known_share * static_cast<double>(distances.size() - 1));
  base.farthest = distances[at];
  base.check();
  return base;
}

}  // namespace raybundle
