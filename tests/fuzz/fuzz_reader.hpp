// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "raybundle/geometry/error.hpp"

namespace raybundle::fuzz {

/// The one thing that a reader may do with bad bytes: throw raybundle::Error. Anything else that leaves it is a bug.
template <typename Read>
int only_errors(const std::uint8_t* data, std::size_t size, Read&& read) {
  try {
    read(std::string_view(reinterpret_cast<const char*>(data), size));
  } catch (const Error&) {
  }
  return 0;
}

/// Stops the fuzzer.
inline void require(bool law, const char* what) {
  if (law) return;
  std::fprintf(stderr, "broken law: %s\n", what);
  std::abort();
}

}  // namespace raybundle::fuzz
