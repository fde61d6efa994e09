// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/structured_light/labels.hpp"

namespace raybundle {

BeamLattice::BeamLattice(const SensorTable& table)
    : rows(table.grid.rows), columns(table.grid.columns), beam_at(static_cast<std::size_t>(rows) * columns, -1) {
  for (const TableBeam& beam : table.beams) {
    beam_at[static_cast<std::size_t>(beam.row) * columns + beam.column] = static_cast<int>(row.size());
    row.push_back(beam.row);
    column.push_back(beam.column);
    direction.push_back(beam.line.direction);
  }
  for (std::size_t b = 0; b < row.size(); ++b) {
    std::array<int, 8> neighbours{};
    std::array<double, 8> angles{};
    std::size_t k = 0;
    for (int r = row[b] - 1; r <= row[b] + 1; ++r) {
      for (int c = column[b] - 1; c <= column[b] + 1; ++c) {
        if (r == row[b] && c == column[b]) continue;
        const bool inside = r >= 0 && r < rows && c >= 0 && c < columns;
        neighbours[k] = inside ? at(r, c) : -1;
        if (neighbours[k] >= 0) angles[k] = (direction[neighbours[k]] - direction[b]).norm();
        ++k;
      }
    }
    around.push_back(neighbours);
    angle.push_back(angles);
  }
}

LabelWork::LabelWork(int most_dots, const SensorTable& table) {
  const std::size_t dots = most_dots, beams = table.beams.size();
  const std::size_t candidates = dots * Candidates::kMostOfDot;
  for (auto* of_dots : {&chosen, &doubtful, &group, &member}) of_dots->reserve(dots);
  no_beam.reserve(dots);
  for (auto* of_candidates : {&weight, &next_weight}) of_candidates->reserve(candidates);
  alive.reserve(candidates);
  of_beam.reserve(candidates);
  dot_of_beam.reserve(beams);
  best_of_beam.reserve(beams);
  first_of_beam.reserve(beams + 1);
}

bool in_order(const LabelTask& task, const Candidate& a, const Candidate& b) {
  const BeamLattice& lattice = task.lattice;
  if (lattice.row[a.beam] != lattice.row[b.beam] && lattice.column[a.beam] != lattice.column[b.beam]) return true;
  const Eigen::Vector3d beams = lattice.direction[b.beam] - lattice.direction[a.beam];
  return beams.dot(task.candidates.ray(b.dot).direction - task.candidates.ray(a.dot).direction) > 0.0;
}

}  // namespace raybundle
