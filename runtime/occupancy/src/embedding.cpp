// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/embedding.hpp"

#include <algorithm>
#include <cassert>

#include "raybundle/geometry/error.hpp"

namespace raybundle {

EmbeddedPlace Embedding::place(const Eigen::Ref<const Eigen::VectorXd>& of_attributes) const {
  assert(of_attributes.size() == attributes());
  EmbeddedPlace values{}, next{};
  for (Eigen::Index i = 0; i < attributes(); ++i) {
    values[i] = (static_cast<float>(of_attributes[i]) - centre[i]) * scale[i];
  }
  for (const EmbeddingLayer& layer : layers) {
    const bool last = &layer == &layers.back();
    std::ranges::copy(layer.offsets, next.begin());
    for (Eigen::Index j = 0; j < layer.weights.cols(); ++j) {
      for (Eigen::Index i = 0; i < layer.weights.rows(); ++i) next[i] += layer.weights(i, j) * values[j];
    }
    if (!last) {
      for (Eigen::Index i = 0; i < layer.weights.rows(); ++i) next[i] = std::max(next[i], 0.0F);
    }
    values = next;
  }
  return values;
}

void Embedding::check(const std::string& where) const {
  bool good = !layers.empty() && attributes() >= 1 && attributes() <= kMostUnits && scale.size() == attributes() &&
              centre.allFinite() && scale.allFinite();
  Eigen::Index in = attributes();
  for (const EmbeddingLayer& layer : layers) {
    const Eigen::Index out = layer.weights.rows();
    good = good && layer.weights.cols() == in && out >= 1 && out <= kMostUnits && layer.offsets.size() == out &&
           layer.weights.allFinite() && layer.offsets.allFinite();
    in = out;
  }
  if (!good) {
    throw Error(ErrorKind::kBadInput,
                "the base of learnt cases is damaged: the layers of its embedding do not fit; learn it again", where);
  }
}

}  // namespace raybundle
