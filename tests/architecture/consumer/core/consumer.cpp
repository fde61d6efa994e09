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
  const Target square{
      .name = "square",
      .points = {{0, {0.0, 0.0, 0.0}}, {1, {0.1, 0.0, 0.0}}, {2, {0.0, 0.1, 0.0}}, {3, {0.1, 0.1, 0.0}}},
      .symmetries = {}};
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
