// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "name_list.hpp"

#include "raybundle/geometry/error.hpp"

namespace raybundle {

void check_as_part_of(const std::string& file, const CalibrationProblem& problem) {
  try {
    check(problem);
  } catch (const Error& error) {
    throw Error(error.kind(), error.what(), file);
  }
}

}  // namespace raybundle
