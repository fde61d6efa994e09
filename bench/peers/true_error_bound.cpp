// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "true_error_bound.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "raybundle/bundle/information.hpp"
#include "raybundle/geometry/rotation.hpp"
#include "raybundle/uncertainty/covariance.hpp"

namespace raybundle::bench {
namespace {

struct Projection {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3> wrt_rotation;
  Eigen::Matrix<double, 2, Eigen::Dynamic> wrt_parameters;
};

// False where the camera does not project the ray.
bool project(const Camera& camera, const Eigen::Vector3d& ray, Projection& out) {
  return with_model(camera.model, [&]<CameraModel M>() {
    Eigen::Matrix<double, 2, 3, Eigen::RowMajor> wrt_ray;
    Eigen::Matrix<double, 2, kParameterCount<M>, Eigen::RowMajor> wrt_parameters;
    if (!pixel_from_ray<M>(camera.parameters.data(), ray, out.pixel, wrt_ray, wrt_parameters)) return false;
    Eigen::Matrix3d wrt_rotation;  // of exp(w) ray, at w = 0
    wrt_rotation << 0, ray.z(), -ray.y(), -ray.z(), 0, ray.x(), ray.y(), -ray.x(), 0;
    out.wrt_rotation = wrt_ray * wrt_rotation;
    out.wrt_parameters = wrt_parameters;
    return true;
  });
}

// Rows and columns of the camera's intrinsics in a covariance.
Eigen::MatrixXd intrinsics_covariance(const Covariance& covariance, const PeerProblem& made, int camera) {
  const ProblemCamera& known = made.problem.cameras[static_cast<std::size_t>(camera)];
  std::vector<int> indices;
  for (const std::string_view parameter : parameter_names(known.model)) {
    const auto found = std::ranges::find(covariance.names, known.name + "." + std::string(parameter));
    indices.push_back(static_cast<int>(found - covariance.names.begin()));
  }
  return covariance.matrix(indices, indices);
}

}  // namespace

TrueErrorBound true_error_bound(const PeerProblem& made, int camera, bool with_shape) {
  BundleOptions options;
  options.estimate_shape = with_shape;
  const CovarianceResult known = covariance(reduced_information(made.problem, made.truth, options));
  const Eigen::MatrixXd sigma = intrinsics_covariance(known.covariance, made, camera) / known.variance_factor;
  const std::vector<GridPoint>& grid = made.grid[static_cast<std::size_t>(camera)];
  const int points = static_cast<int>(grid.size());
  Eigen::MatrixXd wrt_parameters(2 * points, sigma.rows()), wrt_rotation(2 * points, 3);
  for (int i = 0; i < points; ++i) {
    Projection projection;
    project(made.truth.cameras[static_cast<std::size_t>(camera)], grid[static_cast<std::size_t>(i)].ray_in_camera,
            projection);
    wrt_parameters.middleRows<2>(2 * i) = projection.wrt_parameters;
    wrt_rotation.middleRows<2>(2 * i) = projection.wrt_rotation;
  }
  const Eigen::Matrix3d normal = wrt_rotation.transpose() * wrt_rotation;
  wrt_parameters -= wrt_rotation * normal.ldlt().solve(wrt_rotation.transpose() * wrt_parameters);
  return {std::sqrt((wrt_parameters.transpose() * wrt_parameters * sigma).trace() / points)};
}

TrueError true_error(const std::vector<GridPoint>& grid, const Camera& estimated) {
  TrueError error;
  for (int iteration = 0; iteration < 10; ++iteration) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    double sum = 0;
    error.max_px = 0;
    error.unprojectable = 0;
    for (const GridPoint& point : grid) {
      Projection projection;
      if (!project(estimated, error.estimated_from_true * point.ray_in_camera, projection)) {
        ++error.unprojectable;
        continue;
      }
      const Eigen::Vector2d off = projection.pixel - point.pixel;
      normal += projection.wrt_rotation.transpose() * projection.wrt_rotation;
      gradient += projection.wrt_rotation.transpose() * off;
      sum += off.squaredNorm();
      error.max_px = std::max(error.max_px, off.norm());
    }
    error.rms_px = std::sqrt(sum / static_cast<double>(static_cast<int>(grid.size()) - error.unprojectable));
    const Eigen::Vector3d step = -normal.ldlt().solve(gradient);
    if (step.norm() < 1e-12) break;
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(step.norm(), step.normalized()));
    error.estimated_from_true = (turn * error.estimated_from_true).normalized();
  }
  return error;
}

}  // namespace raybundle::bench
