// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "board_point_set.hpp"

#include "raybundle/scene/csv.hpp"

namespace raybundle {

void load_points(Board& board, const std::filesystem::path& folder) {
  auto* set = std::get_if<PointSet>(&board);
  if (set == nullptr) return;
  set->file = (folder / set->file).string();
  CsvTable table = read_csv(set->file);
  arrange_columns(table, {{"point_id", "x", "y", "z"}, {}});
  set->points.clear();
  for (const CsvRow& row : table.rows) {
    set->points.push_back(
        {whole_number_in(table, row, 0, "point_id"),
         {number_in(table, row, 1, "x"), number_in(table, row, 2, "y"), number_in(table, row, 3, "z")}});
  }
}

}  // namespace raybundle
