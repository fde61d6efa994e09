// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// Compiled with AVX2 (CMakeLists.txt), and called only where the machine has it: nothing else may be included here.
#if defined(__AVX2__)
#include "row_kernels_impl.hpp"

namespace raybundle {

const RowKernels& row_kernels_avx2();
const RowKernels& row_kernels_avx2() { return Kernels<Avx2Bytes>::kTable; }

}  // namespace raybundle
#endif
