// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// A program outside of the project that uses the installed package: it projects a ray, knows a board, and is told why
// nothing can be calibrated from no views at all.
#include <iostream>

#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/targets/board.hpp"

int main() {
  using namespace raybundle;
  const Camera camera = start_camera(*model_named("kannala_brandt"), {640, 480}, 200.0);
  const auto pixel = pixel_from_ray(camera, {1.0, 0.0, -0.1});  // beyond 90° off the axis
  std::cout << "pixel " << pixel.value().transpose() << '\n';

  CalibrationProblem problem;
  problem.cameras = {{"left", camera.model, camera.size, {}, {}}};
  problem.targets = {target_of(Chessboard{9, 6, 0.025})};
  try {
    calibrate(problem);
  } catch (const Error& error) {
    std::cout << "refused: " << error.what() << '\n';
    return 0;
  }
  std::cerr << "calibrate() accepted a problem without views\n";
  return 1;
}
