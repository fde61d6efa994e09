// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "raybundle/camera/camera.hpp"
#include "raybundle/geometry/quantile.hpp"
#include "raybundle/geometry/rigid3.hpp"

namespace raybundle {

/// Board points and where one view has them, aligned.
struct PointsInView {
  std::vector<Eigen::Vector3d> points;  ///< in the target [m]
  std::vector<Eigen::Vector2d> pixels;  ///< [px]
};

constexpr int kMaxLensParameters = 24;
using LensMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxLensParameters, kMaxLensParameters>;
using LensVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxLensParameters, 1>;

/// A camera model without its type: fx fy cx cy, then the shape.
struct LensFunctions {
  int parameters = 0;
  bool (*project)(const double* parameters, const Eigen::Vector3d& ray, Eigen::Vector2d& pixel) = nullptr;
  /// wrt_parameters: 2×n row-major
  bool (*project_with_jacobians)(const double* parameters, const Eigen::Vector3d& ray, Eigen::Vector2d& pixel,
                                 Eigen::Matrix<double, 2, 3, Eigen::RowMajor>& wrt_ray,
                                 double* wrt_parameters) = nullptr;
  bool (*unproject)(const double* parameters, const Eigen::Vector2d& pixel, Eigen::Vector3d& ray) = nullptr;
  double (*max_angle_rad)(const double* parameters) = nullptr;
};

template <CameraModel M>
LensFunctions lens_functions() {
  static_assert(kParameterCount<M> <= kMaxLensParameters);
  LensFunctions functions;
  functions.parameters = kParameterCount<M>;
  functions.project = [](const double* parameters, const Eigen::Vector3d& ray, Eigen::Vector2d& pixel) {
    return pixel_from_ray<M>(parameters, ray.data(), pixel.data());
  };
  functions.project_with_jacobians = [](const double* parameters, const Eigen::Vector3d& ray, Eigen::Vector2d& pixel,
                                        Eigen::Matrix<double, 2, 3, Eigen::RowMajor>& wrt_ray, double* wrt_parameters) {
    Eigen::Matrix<double, 2, kParameterCount<M>, Eigen::RowMajor> jacobian;
    if (!pixel_from_ray<M>(parameters, ray, pixel, wrt_ray, jacobian)) return false;
    Eigen::Map<Eigen::Matrix<double, 2, kParameterCount<M>, Eigen::RowMajor>> out(wrt_parameters);
    out = jacobian;
    return true;
  };
  functions.unproject = [](const double* parameters, const Eigen::Vector2d& pixel, Eigen::Vector3d& ray) {
    const double plane[2] = {(pixel.x() - parameters[2]) / parameters[0], (pixel.y() - parameters[3]) / parameters[1]};
    return M::ray_from_plane(parameters + 4, plane, ray.data());
  };
  functions.max_angle_rad = [](const double* parameters) { return M::max_angle_rad(parameters + 4); };
  return functions;
}

/// The functions of a model of the list.
LensFunctions lens_functions(ModelId model);

struct LensBundleOptions {
  double scale_px = 3.0;  ///< of the Geman-McClure loss: corners far beyond have no pull, unprojectable ones neither
  int max_iterations = 20;
  bool poses_fixed = false;
  bool lens_fixed = false;
  bool with_information = false;  ///< fill LensBundleSummary::information
  LensVector prior_mean;          ///< empty: no priors
  LensVector prior_weight;        ///< 1 / sigma of each parameter in units of 1 px of residual; 0: free
  double aspect_weight = 0.0;     ///< 1 / sigma of fy / fx - 1
};

struct LensBundleSummary {
  double cost = 0.0;  ///< robust, [px²], priors included
  int iterations = 0;
  LensMatrix information;  ///< when asked for: about the parameters, poses eliminated, without the priors
};

/// Robust Levenberg-Marquardt over a lens and its board poses, in place; poses eliminated by Schur complement. Small
/// and dense: it only has to bring a start into the basin of the real bundle.
LensBundleSummary refine_lens(const LensFunctions& lens, const std::vector<PointsInView>& views,
                              const LensBundleOptions& options, LensVector& parameters, std::vector<Rigid3>& poses);

/// Distances [px] of a view's corners from where the lens puts them; infinite where it does not project them.
void pixel_distances(const LensFunctions& lens, const double* parameters, const PointsInView& view, const Rigid3& pose,
                     std::vector<double>& distances_px);

}  // namespace raybundle
