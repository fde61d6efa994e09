// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "detection_cache.hpp"

#include "fuzz_reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raybundle;
  static const std::vector<Board> boards{board_from_word("chessboard:4x3:25mm")};
  return fuzz::only_errors(data, size, [](std::string_view text) {
    const auto frames = apps::cached_from_text(text, boards);
    if (!frames) return;
    for (const apps::CachedFrame& frame : *frames) fuzz::require(frame.boards.size() == boards.size(), "every board");
  });
}
