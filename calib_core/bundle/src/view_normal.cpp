// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "view_normal.hpp"

#include "raybundle/geometry/gram.hpp"
#include "view_rows.hpp"

namespace raybundle {

bool accumulate_view(const ViewData& view, const ViewPoint& point, const ViewBlockOptions& options,
                     ViewNormal& normal) {
  thread_local ViewRows rows;
  thread_local Eigen::MatrixXd product;
  if (!fill_rows(view, point, MotionMap(point), options, rows)) return false;
  normal.products.setZero(rows.unknowns() + 1, rows.unknowns() + 1);
  for (int axis = 0; axis < 2; ++axis) {
    gram(axis == 0 ? rows.u : rows.v, product);
    for (int b = 0; b < rows.columns(); ++b) {
      double* column = &normal.products(0, ViewRows::full_column(b, axis));
      for (int a = 0; a <= b; ++a) column[ViewRows::full_column(a, axis)] += product(a, b);
    }
  }
  normal.chi2 = rows.robust_chi2;
  return true;
}

}  // namespace raybundle
