// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/targets/board_file.hpp"

#include "fuzz_reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raybundle;
  return fuzz::only_errors(data, size, [](std::string_view text) {
    const Board board = board_from_toml_text(std::string(text), "fuzz.toml", "no such folder");
    fuzz::require(toml_of(board_from_toml_text(toml_of(board), "again.toml", "")) == toml_of(board),
                  "same board again");
  });
}
