// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/io/observations_file.hpp"

#include "fuzz_reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raybundle;
  return fuzz::only_errors(data, size, [](std::string_view text) {
    const ObservationsFile file = observations_from_text(text, "fuzz.json");
    const std::string written = text_from_observations(file);
    fuzz::require(text_from_observations(observations_from_text(written, "again.json")) == written, "same text again");
  });
}
