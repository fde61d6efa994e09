// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "model_fit.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "view_screen.hpp"

namespace raybundle {
namespace {

constexpr double kGoodFit_px = 0.3;    ///< the polish on corners does the rest
constexpr std::size_t kSamples = 152;  ///< rays that a fit is made on

constexpr std::array kTimesOwnShape{0.5, 0.75, 1.33};  ///< where fits start that look for others than a known one

/// The shapes that a fit is started from.
std::vector<LensVector> starting_shapes(ModelId model) {
  return with_model(model, []<CameraModel M>() {
    std::vector<LensVector> shapes;
    const auto add = [&](const auto& shape) {
      LensVector values(kShapeSize<M>);
      for (int k = 0; k < kShapeSize<M>; ++k) values[k] = shape[static_cast<std::size_t>(k)];
      shapes.push_back(values);
    };
    add(M::kStartShape);
    for (const auto& example : M::kExamples) add(example.shape);
    return shapes;
  });
}

/// Focal lengths that fit best for a given shape and principal point: linear in each axis.
void fit_focal_lengths(const LensFunctions& lens, const PointsInView& samples, LensVector& parameters) {
  LensVector unit = parameters;
  unit.head<4>() << 1, 1, 0, 0;
  Eigen::Array2d products = Eigen::Array2d::Zero();
  Eigen::Array2d squares = Eigen::Array2d::Zero();
  Eigen::Vector2d plane;
  const double reach = 4.0;  // a ray almost at 90° must not rule a rectilinear fit
  for (std::size_t i = 0; i < samples.points.size(); ++i) {
    if (!lens.project(unit.data(), samples.points[i], plane) || !(plane.norm() < reach)) continue;
    products += plane.array() * (samples.pixels[i] - parameters.segment<2>(2)).array();
    squares += plane.array().square();
  }
  for (int axis = 0; axis < 2; ++axis) {
    if (products[axis] > 0 && squares[axis] > 0) parameters[axis] = products[axis] / squares[axis];
  }
}

// Each distance counts up to `most_px`.
double mean_distance_px(const LensFunctions& lens, const PointsInView& samples, const LensVector& parameters,
                        double most_px) {
  std::vector<double> distances;
  pixel_distances(lens, parameters.data(), samples, Rigid3{}, distances);
  double cost = 0.0;
  for (const double distance : distances) cost += std::min(distance, most_px);
  return cost / static_cast<double>(distances.size());
}

}  // namespace

LensBundleOptions model_options(ModelId model, const LensVector& mean, double scale_px) {
  LensBundleOptions options;
  options.scale_px = scale_px;
  options.prior_mean = mean;
  const LensVector neutral = starting_shapes(model).front();
  options.prior_mean.tail(neutral.size()) = neutral;
  options.prior_weight = LensVector::Zero(mean.size());
  options.prior_weight.tail(neutral.size()).setConstant(0.3);  // coefficients are of the size of 1, seldom of 3
  options.aspect_weight = 10.0;                                // pixels are square within 10 %
  return options;
}

namespace {

LensVector fit_from(ModelId model, const LensFunctions& lens, const PointsInView& samples,
                    const LensVector& guess_fx_fy_cx_cy, const LensVector& shape, const std::vector<int>& zeros = {}) {
  LensVector parameters(lens.parameters);
  parameters.head<4>() = guess_fx_fy_cx_cy.head<4>();
  parameters.tail(shape.size()) = shape;
  for (const int zero : zeros) parameters[zero] = 0.0;
  fit_focal_lengths(lens, samples, parameters);
  std::vector<Rigid3> here(1);
  double scale_px = 100.0;
  for (; scale_px > 1.0; scale_px *= 0.3) {
    LensBundleOptions options = model_options(model, parameters, scale_px);
    options.held = zeros;
    options.max_iterations = 15;
    options.poses_fixed = true;
    const double cost = refine_lens(lens, {samples}, options, parameters, here).cost;
    if (cost < kGoodFit_px * kGoodFit_px) break;  // of all samples together: no smaller scale would change anything
  }
  return parameters;
}

}  // namespace

LensVector fit_model(ModelId model, const PointsInView& field, const LensVector& guess_fx_fy_cx_cy,
                     const std::vector<int>& zeros) {
  const LensFunctions lens = lens_functions(model);
  const PointsInView samples = thinned(field, kSamples);
  LensVector best;
  double best_cost = std::numeric_limits<double>::infinity();
  for (const LensVector& shape : starting_shapes(model)) {
    const LensVector parameters = fit_from(model, lens, samples, guess_fx_fy_cx_cy, shape, zeros);
    const double cost = mean_distance_px(lens, samples, parameters, 20.0);
    if (best.size() == 0 || cost < best_cost) {
      best_cost = cost;
      best = parameters;
    }
    if (best_cost < kGoodFit_px) break;
  }
  return best;
}

std::vector<LensVector> model_fits(ModelId model, const PointsInView& field, const LensVector& known) {
  const LensFunctions lens = lens_functions(model);
  const PointsInView samples = thinned(field, kSamples);
  std::vector<LensVector> shapes = starting_shapes(model);
  const LensVector own = known.tail(shapes.front().size());
  for (const double times : kTimesOwnShape) shapes.push_back(times * own);
  std::vector<LensVector> fits;
  for (const LensVector& shape : shapes) fits.push_back(fit_from(model, lens, samples, known, shape));
  return fits;
}

PointsInView field_seen(const Camera& camera, const std::vector<Eigen::Vector3d>& rays_in_camera, std::size_t count) {
  constexpr std::size_t kFewest = 20;
  const LensFunctions lens = lens_functions(camera.model);
  PointsInView field;
  for (const Eigen::Vector3d& ray : rays_in_camera) {
    Eigen::Vector2d pixel;
    if (!lens.project(camera.parameters.data(), ray, pixel)) continue;
    field.points.push_back(ray);
    field.pixels.push_back(pixel);
  }
  return field.points.size() < kFewest ? PointsInView{} : thinned(field, count);
}

}  // namespace raybundle
