// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/io/calibration_file.hpp"

#include "fuzz_reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raybundle;
  return fuzz::only_errors(data, size, [](std::string_view text) {
    const CalibrationFile file = calibration_from_text(text, "fuzz.json");
    const std::string written = text_from_calibration(file);
    fuzz::require(text_from_calibration(calibration_from_text(written, "again.json")) == written, "same text again");
  });
}
