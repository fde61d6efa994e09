// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// Compiled with AVX-512 (CMakeLists.txt), and called only where the machine has it: nothing else may be included here.
#if defined(__AVX512BW__)
#include "row_kernels_impl.hpp"

namespace raybundle {
namespace {

// 64 disparities are one register. Columns that are not a multiple of it, and rows of single pixels, take halves.
template <template <int> typename Call, template <int> typename Half, typename Row>
void columns(const Row& row) {
  if (row.lanes % Avx512Bytes::kCount == 0) return with_columns<Call, Row>(row, row.lanes / Avx512Bytes::kCount);
  with_columns<Half, Row>(row, row.lanes / kLanes);
}

constexpr RowKernels kWide = [] {
  using Wide = Kernels<Avx512Bytes>;
  using Half = Kernels<Avx2Bytes>;
  RowKernels kernels = Half::kTable;
  kernels.census_costs = columns<Wide::CensusCosts, Half::CensusCosts, CensusCostRow>;
  kernels.window = columns<Wide::Window, Half::Window, WindowRow<std::uint8_t>>;
  kernels.across = columns<Wide::Across, Half::Across, PathRow>;
  kernels.along = columns<Wide::Along, Half::Along, PathRow>;
  kernels.best = columns<Wide::Best, Half::Best, PathRow>;
  return kernels;
}();

}  // namespace

const RowKernels& row_kernels_avx512();
const RowKernels& row_kernels_avx512() { return kWide; }

}  // namespace raybundle
#endif
