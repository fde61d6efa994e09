// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/io/observation_tables.hpp"

#include "fuzz_reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raybundle;
  return fuzz::only_errors(data, size, [](std::string_view text) {
    const Target target{"board", {{0, {0, 0, 0}}, {1, {1, 0, 0}}, {2, {0, 1, 0}}, {3, {1, 1, 0}}}, {}};
    observations_from_vnl_text(text, "fuzz.vnl", target,
                               {{"left", "*0.png", {640, 480}}, {"right", "*1.png", {640, 480}}});
  });
}
