// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// A program that needs no detection: it reads corners, and is told why nothing can be calibrated from four.
#include <iostream>
#include <map>

#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/observation_tables.hpp"

int main() {
  using namespace raybundle;
  Target square{.name = "square", .points = {}, .symmetries = {}};
  for (int id = 0; id < 4; ++id) square.points.push_back({id, {0.1 * (id % 2), 0.1 * (id / 2), 0.0}});
  const std::map<std::string, ImageSize> sizes{{"left", {640, 480}}};
  try {
    CalibrationProblem problem = observations_from_csv_text(
        "left,1,0,100,100\nleft,1,1,200,100\nleft,1,2,100,200\nleft,1,3,200,200\n", "corners", square, sizes);
    problem.cameras[0].model = *model_named("pinhole");
    calibrate(problem);
  } catch (const Error& error) {
    std::cout << "refused: " << error.what() << '\n';
    return error.kind() == ErrorKind::kNotEnoughData ? 0 : 1;
  }
  std::cerr << "calibrate() accepted four corners\n";
  return 1;
}
