// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "raybundle/geometry/error.hpp"

namespace raybundle {

/// Throws Error(kBadInput) with the message when a condition does not hold.
inline void require(bool holds, const std::string& message) {
  if (!holds) throw Error(ErrorKind::kBadInput, message);
}

}  // namespace raybundle
