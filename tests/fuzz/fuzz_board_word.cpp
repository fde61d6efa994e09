// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/targets/board.hpp"

#include "fuzz_reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raybundle;
  return fuzz::only_errors(data, size, [](std::string_view text) {
    if (text.starts_with("points")) return;  // would open the file that the bytes name
    const Board board = board_from_word(std::string(text));
    fuzz::require(word_of(board_from_word(word_of(board))) == word_of(board), "same board again");
  });
}
