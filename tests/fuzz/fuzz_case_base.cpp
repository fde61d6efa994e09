// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "fuzz_reader.hpp"
#include "raybundle/occupancy/case_base_file.hpp"

// The checksums would stop nearly every input: the fuzzer's bytes are the payload, and get a right header.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raybundle;
  return fuzz::only_errors(data, size, [](std::string_view payload) {
    const CaseBase base = case_base_from_bytes(checked_file(kCaseBaseKind, payload), "fuzz.rbcases");
    const std::string written = bytes_from_case_base(base);
    fuzz::require(bytes_from_case_base(case_base_from_bytes(written, "again.rbcases")) == written, "same bytes again");
  });
}
