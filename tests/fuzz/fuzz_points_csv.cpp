// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/scene/csv.hpp"

#include "fuzz_reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raybundle;
  return fuzz::only_errors(data, size, [](std::string_view text) {
    CsvTable table = csv_from_text(text, "fuzz.csv");
    arrange_columns(table, {{"point_id", "x", "y", "z"}, {}});
    for (const CsvRow& row : table.rows) {
      whole_number_in(table, row, 0, "point_id");
      for (const std::size_t column : {1u, 2u, 3u}) number_in(table, row, column, "x");
    }
  });
}
