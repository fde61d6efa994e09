// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "file_of.hpp"
#include "fuzz_reader.hpp"
#include "gates.hpp"

// A file of requirements, and the words of one.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raybundle;
  fuzz::only_errors(data, size, [](std::string_view text) {
    const double limit = requirement_from_text(text).limit;
    fuzz::require(limit >= 0.0 && std::isfinite(limit), "a limit that can be met");
  });
  return fuzz::only_errors(data, size, [](std::string_view text) {
    fuzz::require(!apps::requirements_of({{}, fuzz::file_of("gates.toml", text)}).empty(), "it requires something");
  });
}
