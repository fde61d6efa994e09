// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/embedding.hpp"

#include <gtest/gtest.h>

#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

Embedding two_layers() {
  Embedding embedding{.centre = Eigen::Vector2f(1, -1), .scale = Eigen::Vector2f(2, 0.5), .layers = {}};
  Eigen::MatrixXf first(2, 2), second(1, 2);
  first << 1, 0, 0, -1;
  second << 3, 5;
  embedding.layers = {{first, Eigen::Vector2f(0, 1)}, {second, Eigen::VectorXf::Constant(1, -20.0F)}};
  return embedding;
}

// By hand: scaled attributes 4 and 2; between the layers 4 and, cut at zero, 0; the last layer is not cut.
TEST(Embedding, ScalesWeighsAndCutsBetweenLayersOnly) {
  const Embedding embedding = two_layers();
  EXPECT_EQ(embedding.size(), 1);
  EXPECT_FLOAT_EQ(embedding.place(Eigen::Vector2d(3, 3))[0], 3 * 4 - 20.0F);
}

TEST(Embedding, LayersThatDoNotFitAreRefused) {
  Embedding embedding = two_layers();
  EXPECT_NO_THROW(embedding.check());
  embedding.layers[1].weights.resize(1, 3);
  embedding.layers[1].weights.setZero();
  EXPECT_THROW(embedding.check(), Error);
  EXPECT_THROW(Embedding{}.check(), Error);
}

}  // namespace
}  // namespace raybundle
