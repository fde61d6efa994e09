// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "embedding_search.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace raybundle {
namespace {

constexpr float kRate = 2e-3F;        // of the steps, falling to zero
constexpr float kFirstPlace = 0.15F;  // the last layer starts so small that every case has neighbours

// Parameters with the running moments of their gradient.
class Moved {
 public:
  void step(Eigen::Ref<Eigen::MatrixXf> values, const Eigen::MatrixXf& gradient, float rate, int at) {
    constexpr float kFirst = 0.9F, kSecond = 0.99F, kLeast = 1e-8F;
    if (mean_.size() == 0) mean_ = square_ = Eigen::MatrixXf::Zero(values.rows(), values.cols());
    mean_ = kFirst * mean_ + (1 - kFirst) * gradient;
    square_ = kSecond * square_ + (1 - kSecond) * gradient.cwiseAbs2();
    const auto t = static_cast<float>(at);
    const float unbiased = rate * std::sqrt(1 - std::pow(kSecond, t)) / (1 - std::pow(kFirst, t));
    values -= unbiased * (mean_.array() / (square_.array().sqrt() + kLeast)).matrix();
  }

 private:
  Eigen::MatrixXf mean_, square_;
};

Embedding start_of(const Eigen::MatrixXf& attributes, const std::vector<int>& sizes, std::mt19937_64& random) {
  constexpr float kLeastScatter = 1e-4F;  // an attribute that never varies tells nothing
  Embedding start;
  start.centre = attributes.rowwise().mean();
  const Eigen::VectorXf variance =
      (attributes.colwise() - start.centre).rowwise().squaredNorm() / static_cast<float>(attributes.cols());
  start.scale = variance.cwiseSqrt().cwiseMax(kLeastScatter).cwiseInverse();
  Eigen::Index in = attributes.rows();
  for (const int& size : sizes) {
    // Even numbers by hand: the distributions of the standard library differ between libraries.
    const float most = std::sqrt(6.0F / static_cast<float>(in)) * (&size == &sizes.back() ? kFirstPlace : 1.0F);
    EmbeddingLayer layer{Eigen::MatrixXf(size, in), Eigen::VectorXf::Zero(size)};
    for (float& weight : layer.weights.reshaped()) {
      weight = most * (static_cast<float>(random() >> 40) * 0x1p-23F - 1.0F);
    }
    start.layers.push_back(layer);
    in = size;
  }
  return start;
}

// Of minus the mean over the batch of log p, p being the share of a case's neighbourhood that is of its kind.
Eigen::MatrixXf gradient_of_places(const Eigen::MatrixXf& places, const std::vector<int>& kinds) {
  const Eigen::VectorXf squares = places.colwise().squaredNorm().transpose();
  Eigen::MatrixXf pull = 2.0F * places.transpose() * places;  // column: a case; row: a neighbour of it
  pull.colwise() -= squares;
  pull.rowwise() -= squares.transpose();  // minus the squared distances
  for (Eigen::Index i = 0; i < pull.cols(); ++i) {
    pull(i, i) = -INFINITY;
    pull.col(i) = (pull.col(i).array() - pull.col(i).maxCoeff()).exp();
    pull.col(i) /= pull.col(i).sum();
    float own = 1e-6F;
    for (Eigen::Index j = 0; j < pull.rows(); ++j) own += kinds[j] == kinds[i] ? pull(j, i) : 0.0F;
    for (Eigen::Index j = 0; j < pull.rows(); ++j)
      pull(j, i) = (kinds[j] == kinds[i] ? pull(j, i) / own : 0.0F) - pull(j, i);
  }
  const Eigen::VectorXf by_case = pull.colwise().sum().transpose(), by_neighbour = pull.rowwise().sum();
  return (2.0F / static_cast<float>(pull.cols())) *
         (places * (by_case + by_neighbour).asDiagonal() - places * pull - places * pull.transpose());
}

// 1 / (1 - share) or, for that share of the values, 0.
Eigen::MatrixXf kept(Eigen::Index rows, Eigen::Index columns, double share, std::mt19937_64& random) {
  Eigen::MatrixXf mask(rows, columns);
  const auto left_out = static_cast<std::uint64_t>(std::lround(256 * share));
  std::uint64_t bits = 0;
  for (Eigen::Index i = 0; i < mask.size(); ++i, bits >>= 8) {
    if (i % 8 == 0) bits = random();
    mask.data()[i] = (bits & 255) < left_out ? 0.0F : static_cast<float>(1.0 / (1.0 - share));
  }
  return mask;
}

}  // namespace

Embedding embedding_search(const Eigen::MatrixXf& attributes, const std::vector<int>& kinds,
                           const EmbeddingSearch& search) {
  std::mt19937_64 random(search.seed);
  Embedding found = start_of(attributes, search.sizes, random);
  const std::size_t depth = found.layers.size();
  const Eigen::Index batch = std::min<Eigen::Index>(kEmbeddingBatch, attributes.cols());
  std::vector<Moved> weights(depth), offsets(depth);
  std::vector<Eigen::MatrixXf> values(depth + 1), masks(depth);
  std::vector<int> kinds_of_batch(static_cast<std::size_t>(batch));
  for (int step = 1; step <= search.steps; ++step) {
    values[0].resize(attributes.rows(), batch);
    for (Eigen::Index i = 0; i < batch; ++i) {
      const auto n = static_cast<Eigen::Index>(random() % static_cast<std::uint64_t>(attributes.cols()));
      values[0].col(i) = (attributes.col(n) - found.centre).cwiseProduct(found.scale);
      kinds_of_batch[i] = kinds[n];
    }
    for (std::size_t i = 0; i < depth; ++i) {
      values[i + 1] = (found.layers[i].weights * values[i]).colwise() + found.layers[i].offsets;
      if (i + 1 == depth) break;
      masks[i] = kept(values[i + 1].rows(), batch, search.dropout, random);
      values[i + 1] = values[i + 1].cwiseMax(0.0F).cwiseProduct(masks[i]);
    }
    const float rate = kRate * 0.5F * (1.0F + static_cast<float>(std::cos(M_PI * step / search.steps)));
    Eigen::MatrixXf down = gradient_of_places(values[depth], kinds_of_batch);
    for (std::size_t i = depth; i-- > 0;) {
      EmbeddingLayer& layer = found.layers[i];
      const Eigen::MatrixXf of_weights =
          down * values[i].transpose() + static_cast<float>(search.decay) * layer.weights;
      const Eigen::VectorXf of_offsets = down.rowwise().sum();
      if (i > 0) {
        down = (layer.weights.transpose() * down)
                   .cwiseProduct(masks[i - 1])
                   .cwiseProduct((values[i].array() > 0.0F).cast<float>().matrix());
      }
      weights[i].step(layer.weights, of_weights, rate, step);
      offsets[i].step(layer.offsets, of_offsets, rate, step);
    }
  }
  return found;
}

}  // namespace raybundle
