// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "projection.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "raybundle/geometry/rotation.hpp"

namespace raybundle::testing {
namespace {

/// Pixel of a ray with its derivatives by the parameters and by a small turn of the ray.
struct Linearized {
  Eigen::Vector2d pixel;
  Eigen::MatrixXd wrt_parameters;
  Eigen::Matrix<double, 2, 3> wrt_turn;
};

bool linearize(const Camera& camera, const Eigen::Vector3d& ray, Linearized& at) {
  return with_model(camera.model, [&]<CameraModel M>() {
    Eigen::Matrix<double, 2, 3, Eigen::RowMajor> wrt_ray;
    Eigen::Matrix<double, 2, kParameterCount<M>, Eigen::RowMajor> wrt_parameters;
    if (!pixel_from_ray<M>(camera.parameters.data(), ray, at.pixel, wrt_ray, wrt_parameters)) return false;
    at.wrt_parameters = wrt_parameters;
    at.wrt_turn = -wrt_ray * skew(ray);
    return true;
  });
}

/// The turn that brings rays of a camera nearest to those that another one has for the same pixels.
Eigen::Matrix3d turn_between(const Camera& reference, const Camera& other, const std::vector<Eigen::Vector3d>& rays) {
  Eigen::Matrix3d correlation = 1e-12 * Eigen::Matrix3d::Identity();
  for (const Eigen::Vector3d& ray : rays) {
    const auto pixel = pixel_from_ray(reference, ray);
    const auto of_other = pixel ? ray_from_pixel(other, *pixel) : std::nullopt;
    if (of_other) correlation += *of_other * ray.transpose();
  }
  return nearest_rotation(correlation);
}

}  // namespace

double projection_difference_px(const Camera& reference, const Camera& other,
                                const std::vector<Eigen::Vector3d>& rays_in_reference) {
  Eigen::Matrix3d turn = turn_between(reference, other, rays_in_reference);
  double rms = std::numeric_limits<double>::infinity();
  Linearized at;
  for (int iteration = 0; iteration < 10; ++iteration) {
    Eigen::Matrix3d normal = 1e-12 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    double sum = 0.0;
    std::size_t count = 0;
    for (const Eigen::Vector3d& ray : rays_in_reference) {
      const auto wanted = pixel_from_ray(reference, ray);
      if (!wanted || !linearize(other, turn * ray, at)) continue;
      const Eigen::Vector2d off = at.pixel - *wanted;
      normal += at.wrt_turn.transpose() * at.wrt_turn;
      gradient += at.wrt_turn.transpose() * off;
      sum += off.squaredNorm();
      ++count;
    }
    if (count == 0 || 100 * count < 99 * rays_in_reference.size()) return std::numeric_limits<double>::infinity();
    rms = std::sqrt(sum / static_cast<double>(count));
    turn = rotation_from_vector(-normal.ldlt().solve(gradient)) * turn;
  }
  return rms;
}

Eigen::MatrixXd covariance_of_intrinsics(const Covariance& covariance, const std::string& camera, ModelId model) {
  const std::vector<std::string_view> names = parameter_names(model);
  const auto count = static_cast<Eigen::Index>(names.size());
  std::vector<Eigen::Index> at(names.size());  // in the covariance; past its end where it has none
  for (std::size_t k = 0; k < names.size(); ++k) {
    at[k] = std::ranges::find(covariance.names, camera + "." + std::string(names[k])) - covariance.names.begin();
  }
  Eigen::MatrixXd block = Eigen::MatrixXd::Zero(count, count);
  for (Eigen::Index row = 0; row < count; ++row) {
    for (Eigen::Index column = 0; column < count; ++column) {
      const Eigen::Index from = at[row], to = at[column];
      const bool known = std::max(from, to) < covariance.matrix.rows();
      if (known) block(row, column) = covariance.matrix(from, to);
    }
  }
  return block;
}

double projection_sigma_px(const Camera& camera, const Eigen::MatrixXd& covariance,
                           const std::vector<Eigen::Vector3d>& rays_in_camera) {
  const auto rows = static_cast<Eigen::Index>(2 * rays_in_camera.size());
  Eigen::MatrixXd by_parameters = Eigen::MatrixXd::Zero(rows, camera.parameters.size());
  Eigen::MatrixXd by_turn = Eigen::MatrixXd::Zero(rows, 3);
  Linearized at;
  for (std::size_t i = 0; i < rays_in_camera.size(); ++i) {
    if (!linearize(camera, rays_in_camera[i], at)) continue;
    by_parameters.middleRows<2>(static_cast<Eigen::Index>(2 * i)) = at.wrt_parameters;
    by_turn.middleRows<2>(static_cast<Eigen::Index>(2 * i)) = at.wrt_turn;
  }
  by_parameters -= by_turn * by_turn.colPivHouseholderQr().solve(by_parameters);
  const double sum = (by_parameters * covariance).cwiseProduct(by_parameters).sum();
  return std::sqrt(sum / static_cast<double>(rays_in_camera.size()));
}

}  // namespace raybundle::testing
