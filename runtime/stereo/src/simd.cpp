// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/stereo/simd.hpp"

namespace raybundle {

Simd best_simd() {
#if defined(__x86_64__)
  static const Simd best = __builtin_cpu_supports("avx2") ? Simd::kAvx2 : Simd::kNone;
  return best;
#else
  return Simd::kNone;
#endif
}

}  // namespace raybundle
