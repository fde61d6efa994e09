// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "cost_kernels_impl.hpp"
#include "path_kernels_impl.hpp"
#include "refine_kernels_impl.hpp"

// The loops of row_kernels.hpp for one kind of bytes. Included once by the source file of each kind, so that each is
// compiled for its own instructions.

namespace raybundle {
namespace {

template <template <int> typename Call, typename Row>
void with_columns(const Row& row, int registers) {
  switch (registers) {
    case 1:
      return Call<1>::of(row);
    case 2:
      return Call<2>::of(row);
    case 3:
      return Call<3>::of(row);
    case 4:
      return Call<4>::of(row);
    case 6:
      return Call<6>::of(row);
    default:
      return Call<8>::of(row);
  }
}

template <typename Bytes>
struct Kernels {
  template <int n>
  struct CensusCosts {
    static void of(const CensusCostRow& row) { census_cost_row<Bytes, n>(row); }
  };
  template <int n>
  struct Window {
    static void of(const WindowRow<std::uint8_t>& row) { window_row<Bytes, n>(row); }
  };
  template <int n>
  struct Across {
    static void of(const PathRow& row) { across_row<Bytes, n>(row); }
  };
  template <int n>
  struct Along {
    static void of(const PathRow& row) { along_row<Bytes, n>(row); }
  };
  template <int n>
  struct Best {
    static void of(const PathRow& row) { best_row<Bytes, n>(row); }
  };
  template <template <int> typename Call, typename Row>
  static void columns(const Row& row) {
    with_columns<Call, Row>(row, row.lanes / Bytes::kCount);
  }
  static constexpr RowKernels kTable{census_row<Bytes>,
                                     columns<CensusCosts, CensusCostRow>,
                                     enter_row<Bytes>,
                                     enter_row_wide,
                                     columns<Window, WindowRow<std::uint8_t>>,
                                     window_row_wide,
                                     square_row,
                                     correlation_row,
                                     square_cost_row,
                                     correlation_cost_row,
                                     columns<Across, PathRow>,
                                     columns<Along, PathRow>,
                                     columns<Best, PathRow>,
                                     judge_row,
                                     count_row,
                                     across_window_row,
                                     difference_row,
                                     refine_row};
};

}  // namespace
}  // namespace raybundle
