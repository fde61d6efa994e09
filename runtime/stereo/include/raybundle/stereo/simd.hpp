// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace raybundle {

/// Which instructions the loops use. All give the same bits.
enum class Simd : unsigned char { kNone, kAvx2 };

/// Whether this machine has them.
bool has(Simd simd);

/// The fastest that this machine has.
Simd best_simd();

}  // namespace raybundle
