// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/stereo/simd.hpp"

namespace raybundle {

bool has(Simd simd) {
#if defined(__x86_64__)
  if (simd == Simd::kAvx2) return __builtin_cpu_supports("avx2");
#endif
  return simd == Simd::kNone;
}

Simd best_simd() {
  static const Simd best = has(Simd::kAvx2) ? Simd::kAvx2 : Simd::kNone;
  return best;
}

}  // namespace raybundle
