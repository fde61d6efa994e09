// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "image_sigmas.hpp"

#include <utility>

#include "raybundle/geometry/target_clones.hpp"
#include "raybundle/scene/parameter_names.hpp"
#include "raybundle/uncertainty/image_cells.hpp"
#include "raybundle/uncertainty/projection_uncertainty.hpp"

namespace raybundle {
namespace {

// Derivatives of the pixel by the lens's parameters, for places all over the image that have a ray.
std::vector<Eigen::Matrix2Xd> derivatives_over_image(const RigCamera& camera, int across) {
  const ProjectionUncertainty uncertainty = projection_uncertainty(camera, {});
  const ImageSize size = camera.camera.size;
  const int rows = rows_of_square_cells(size, across);
  std::vector<Eigen::Matrix2Xd> all;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < across; ++column) {
      const Eigen::Vector2d pixel = middle_of_cell(size, rows, across, row, column);
      auto derivatives = projection_derivatives(uncertainty, pixel, kInfinitelyFar);
      if (derivatives) all.push_back(std::move(*derivatives));
    }
  }
  return all;
}

RAYBUNDLE_TARGET_CLONES
void add(double factor, const double* __restrict values, Eigen::Index count, double* __restrict sums) {
  for (Eigen::Index i = 0; i < count; ++i) sums[i] += factor * values[i];
}

}  // namespace

ImageSigmas::ImageSigmas(const RigCamera& camera, const Covariance& known, int across) {
  const std::vector<Eigen::Matrix2Xd> derivatives = derivatives_over_image(camera, across);
  const std::vector<int> all = known.places_of(intrinsic_names(camera));
  std::vector<Eigen::Index> columns;  // of the derivatives
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (all[k] < 0) continue;
    columns.push_back(static_cast<Eigen::Index>(k));
    estimated_.push_back(all[k]);
  }
  const auto places = std::ssize(derivatives);
  const auto count = std::ssize(columns);
  products_.resize(3 * places, count * (count + 1) / 2);
  for (Eigen::Index i = 0; i < places; ++i) {
    const Eigen::Matrix2Xd by = derivatives[i](Eigen::all, columns);
    Eigen::Index pair = 0;
    for (Eigen::Index b = 0; b < count; ++b) {
      for (Eigen::Index a = 0; a <= b; ++a, ++pair) {
        const double twice = a < b ? 2.0 : 1.0;  // the covariance has both
        products_(i, pair) = twice * by(0, a) * by(0, b);
        products_(places + i, pair) = twice * by(1, a) * by(1, b);
        products_(2 * places + i, pair) = 0.5 * twice * (by(0, a) * by(1, b) + by(1, a) * by(0, b));
      }
    }
  }
}

Eigen::ArrayXd ImageSigmas::largest_variances(const Eigen::MatrixXd& covariance) const {
  const Eigen::Index places = products_.rows() / 3;
  Eigen::ArrayXd sums = Eigen::ArrayXd::Zero(3 * places);
  Eigen::Index pair = 0;
  for (std::size_t b = 0; b < estimated_.size(); ++b) {
    for (std::size_t a = 0; a <= b; ++a, ++pair) {
      add(covariance(estimated_[a], estimated_[b]), products_.col(pair).data(), sums.size(), sums.data());
    }
  }
  const auto uu = sums.head(places), vv = sums.segment(places, places), uv = sums.tail(places);
  return 0.5 * (uu + vv + ((uu - vv).square() + 4.0 * uv.square()).sqrt());
}

}  // namespace raybundle
