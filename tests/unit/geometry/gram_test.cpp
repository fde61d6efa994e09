// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/geometry/gram.hpp"

#include <gtest/gtest.h>

namespace raybundle {
namespace {

// Whole numbers, whose products and sums are exact in whichever order: what is not equal is wrong.
Eigen::MatrixXd whole_numbers(int rows, int columns) {
  return (100.0 * Eigen::MatrixXd::Random(rows, columns)).array().round();
}

// Of every size, so that tiles end in all ways; and of no rows.
TEST(Gram, IsTheUpperTriangleOfTheProduct) {
  for (int rows = 0; rows <= 32; rows += 4) {
    for (int columns = 1; columns <= 30; ++columns) {
      const Eigen::MatrixXd matrix = whole_numbers(rows, columns);
      Eigen::MatrixXd product;
      gram(matrix, product);
      ASSERT_EQ(product.rows(), columns);
      ASSERT_EQ(product.cols(), columns);
      const Eigen::MatrixXd difference = product - matrix.transpose() * matrix;
      EXPECT_TRUE(Eigen::MatrixXd(difference.triangularView<Eigen::Upper>()).isZero(0)) << rows << "x" << columns;
    }
  }
}

TEST(Gram, OverwritesWhatWasThere) {
  const Eigen::MatrixXd matrix = whole_numbers(8, 5);
  Eigen::MatrixXd product = Eigen::MatrixXd::Constant(7, 7, 1e9), again = Eigen::MatrixXd::Constant(5, 5, 1e9);
  gram(matrix, product);
  gram(matrix, again);
  EXPECT_EQ(Eigen::MatrixXd(product.triangularView<Eigen::Upper>()),
            Eigen::MatrixXd(again.triangularView<Eigen::Upper>()));
  EXPECT_EQ(product(0, 4), matrix.col(0).dot(matrix.col(4)));
}

}  // namespace
}  // namespace raybundle
