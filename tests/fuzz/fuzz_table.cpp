// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "fuzz_reader.hpp"
#include "raybundle/device/checked_file.hpp"
#include "raybundle/structured_light/table_file.hpp"

// The checksums would stop nearly every input: the fuzzer's bytes are the payload, and get a right header.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raybundle;
  return fuzz::only_errors(data, size, [](std::string_view payload) {
    const SensorTable table = table_from_bytes(checked_file(kTableKind, payload), "fuzz.rbsl");
    const std::string written = bytes_from_table(table);
    fuzz::require(bytes_from_table(table_from_bytes(written, "again.rbsl")) == written, "same bytes again");
  });
}
