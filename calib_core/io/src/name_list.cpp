// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "name_list.hpp"

#include <utility>

#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

// Two points of a board are never measured at the same place to the last bit: a line was copied.
void refuse_repeated_pixels(const CalibrationProblem& problem, const TargetView& view) {
  std::map<std::pair<double, double>, int> id_at;
  for (const Observation& observation : view.observations) {
    const auto [other, is_new] =
        id_at.try_emplace({observation.pixel.x(), observation.pixel.y()}, observation.point_id);
    if (is_new) continue;
    throw Error(ErrorKind::kBadInput,
                "points " + std::to_string(other->second) + " and " + std::to_string(observation.point_id) +
                    " have the same pixel; leave out the wrong one",
                view_name(problem, view));
  }
}

}  // namespace

void check_as_part_of(const std::string& file, const CalibrationProblem& problem) {
  try {
    check(problem);
    for (const TargetView& view : problem.views) refuse_repeated_pixels(problem, view);
  } catch (const Error& error) {
    throw Error(error.kind(), error.what(), file);
  }
}

}  // namespace raybundle
