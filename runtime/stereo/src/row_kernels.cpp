// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "row_kernels.hpp"

#include "row_kernels_impl.hpp"

namespace raybundle {

#if defined(RAYBUNDLE_STEREO_X86)
const RowKernels& row_kernels_avx2();
#endif

const RowKernels& row_kernels(Simd simd) {
#if defined(RAYBUNDLE_STEREO_X86)
  if (simd == Simd::kAvx2) return row_kernels_avx2();
#else
  static_cast<void>(simd);
#endif
  return Kernels<PlainBytes>::kTable;
}

}  // namespace raybundle
