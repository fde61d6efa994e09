// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "updated_covariance.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "raybundle/geometry/gram.hpp"
#include "raybundle/geometry/target_clones.hpp"

namespace raybundle {
namespace {

using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// [A B] become [L', L^-1 B] with A = L L' positive definite, of which the upper triangle is read.
RAYBUNDLE_TARGET_CLONES
void eliminate(Rows& rows) {
  const Eigen::Index count = rows.rows(), columns = rows.cols();
  for (Eigen::Index i = 0; i < count; ++i) {
    double* const __restrict pivot = rows.data() + i * columns;
    const double scale = 1.0 / std::sqrt(pivot[i]);
    for (Eigen::Index c = i; c < columns; ++c) pivot[c] *= scale;
    for (Eigen::Index r = i + 1; r < count; ++r) {
      double* const __restrict row = rows.data() + r * columns;
      const double share = pivot[r];
      for (Eigen::Index c = r; c < columns; ++c) row[c] -= share * pivot[c];
    }
  }
}

}  // namespace

Eigen::MatrixXd root_of(const Eigen::MatrixXd& covariance) {
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(covariance);
  const Eigen::MatrixXd lower = ldlt.matrixL();
  return ldlt.transpositionsP().transpose() * (lower * ldlt.vectorD().cwiseMax(0.0).cwiseSqrt().asDiagonal());
}

Eigen::MatrixXd updated(const Eigen::MatrixXd& root, const Eigen::MatrixXd& whitened_information) {
  const Eigen::Index size = root.rows();
  Rows both(size, 2 * size);
  both.leftCols(size) = whitened_information;
  both.leftCols(size).diagonal().array() += 1.0;
  both.rightCols(size) = root.transpose();
  eliminate(both);
  Eigen::MatrixXd rows(padded_for_gram(size), size), product;
  rows.topRows(size) = both.rightCols(size);
  rows.bottomRows(rows.rows() - size).setZero();
  gram(rows, product);
  product.triangularView<Eigen::StrictlyLower>() = product.transpose();
  return product;
}

}  // namespace raybundle
