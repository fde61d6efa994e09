// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "kalibr_corners.hpp"

#include <fstream>
#include <sstream>
#include <vector>

namespace raybundle::testing {

std::string csv_of_kalibr_corners(const std::filesystem::path& folder, const std::string& camera) {
  std::string csv;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::ifstream file(entry.path());
    for (std::string line; std::getline(file, line);) {
      if (line.starts_with("#")) continue;
      std::vector<std::string> cells;
      std::istringstream rest(line);
      for (std::string cell; std::getline(rest, cell, ',');) cells.push_back(cell);
      if (cells.size() < 12) continue;
      const int id = 4 * std::stoi(cells[10]) + std::stoi(cells[11]);
      csv += camera + "," + cells[0] + "," + std::to_string(id) + "," + cells[5] + "," + cells[6] + "\n";
    }
  }
  return csv;
}

}  // namespace raybundle::testing
