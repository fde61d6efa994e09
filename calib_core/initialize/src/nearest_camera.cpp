// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/initialize/nearest_camera.hpp"

#include <limits>

#include "model_fit.hpp"

namespace raybundle {

Camera nearest_camera(const std::vector<PixelRay>& rays, const Camera& camera, ModelId model,
                      const std::vector<int>& zeros) {
  PointsInView field;
  for (const auto& [pixel, ray] : rays) {
    field.points.push_back(ray);
    field.pixels.push_back(pixel);
  }
  LensVector guess(4);
  guess << Eigen::Vector2d::Constant(focal_on_axis_px(camera)), camera.parameters.segment<2>(2);
  LensVector parameters = fit_model(model, field, guess, zeros);

  LensBundleOptions options;
  options.scale_px = 1e6;  // so wide that the loss is a square
  options.max_iterations = 100;
  options.poses_fixed = true;
  options.held = zeros;
  std::vector<Rigid3> here(1);
  // refine_lens ends where corners would not tell the difference; here there is no noise.
  double cost = std::numeric_limits<double>::infinity();
  for (double last = cost;
       (cost = refine_lens(lens_functions(model), {field}, options, parameters, here).cost) < 0.999 * last;) {
    last = cost;
  }
  return {model, camera.size, parameters};
}

}  // namespace raybundle
