// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace raybundle {

inline constexpr int kMaxImageSide_px = 1'000'000;  ///< beyond that the width or height in a file is a mistake

}  // namespace raybundle
