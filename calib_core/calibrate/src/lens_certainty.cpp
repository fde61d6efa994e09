// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "lens_certainty.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "local_optima.hpp"
#include "raybundle/bundle/information.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/rotation.hpp"
#include "raybundle/scene/parameter_names.hpp"
#include "raybundle/uncertainty/covariance.hpp"

namespace raybundle {
namespace {

constexpr double kOpenShare = 0.02;  // of the image's longer side

double open_limit_px(ImageSize size) { return kOpenShare * std::max(size.width, size.height); }

/// Slopes of the pixels of rays by the intrinsics, in the order of the model, and by a turn of the camera.
struct Slopes {
  Eigen::MatrixXd by_parameters;
  Eigen::MatrixXd by_turn;
};

Slopes slopes_of(const Camera& camera, const std::vector<Eigen::Vector3d>& rays) {
  return with_model(camera.model, [&]<CameraModel M>() {
    const auto rows = static_cast<Eigen::Index>(2 * rays.size());
    Slopes slopes{Eigen::MatrixXd::Zero(rows, kParameterCount<M>), Eigen::MatrixXd::Zero(rows, 3)};
    Eigen::Vector2d pixel;
    Eigen::Matrix<double, 2, 3, Eigen::RowMajor> wrt_ray;
    Eigen::Matrix<double, 2, kParameterCount<M>, Eigen::RowMajor> wrt_parameters;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (!pixel_from_ray<M>(camera.parameters.data(), rays[i], pixel, wrt_ray, wrt_parameters)) continue;
      slopes.by_parameters.template middleRows<2>(static_cast<Eigen::Index>(2 * i)) = wrt_parameters;
      slopes.by_turn.template middleRows<2>(static_cast<Eigen::Index>(2 * i)) = -wrt_ray * skew(rays[i]);
    }
    return slopes;
  });
}

}  // namespace

Eigen::MatrixXd covariance_of_lens(const CalibrationProblem& single, const BundleState& state, int threads) {
  BundleOptions bundle;
  bundle.threads = threads;
  const Covariance known = covariance(reduced_information(single, state, bundle)).covariance;
  return known.block(intrinsic_names(single.cameras[0].name, state.cameras[0].model));
}

double projection_sigma_px(const CalibrationProblem& single, const BundleState& state, int threads) {
  const std::vector<Eigen::Vector3d> rays = rays_seen(single, state);
  if (rays.empty()) return 0.0;
  auto [by_parameters, by_turn] = slopes_of(state.cameras[0], rays);
  by_parameters -= by_turn * by_turn.colPivHouseholderQr().solve(by_parameters);
  const double sum = (by_parameters * covariance_of_lens(single, state, threads)).cwiseProduct(by_parameters).sum();
  return std::sqrt(std::max(0.0, sum) / static_cast<double>(rays.size()));
}

double projection_distance_px(const Camera& camera, const Camera& other,
                              const std::vector<Eigen::Vector3d>& rays_in_camera) {
  constexpr int kTurns = 5;  // Gauss-Newton: the turn is small
  std::vector<Eigen::Vector3d> turned = rays_in_camera;
  Eigen::VectorXd apart(2 * std::ssize(turned));
  const auto measure = [&] {
    for (std::size_t i = 0; i < turned.size(); ++i) {
      const auto here = pixel_from_ray(camera, rays_in_camera[i]), there = pixel_from_ray(other, turned[i]);
      if (!here || !there) return false;
      apart.segment<2>(static_cast<Eigen::Index>(2 * i)) = *there - *here;
    }
    return true;
  };
  for (int round = 0; round < kTurns; ++round) {
    if (!measure()) return std::numeric_limits<double>::infinity();
    const Eigen::MatrixXd by_turn = slopes_of(other, turned).by_turn;
    const Eigen::Matrix3d turn = rotation_from_vector(Eigen::Vector3d(by_turn.colPivHouseholderQr().solve(-apart)));
    for (Eigen::Vector3d& ray : turned) ray = turn * ray;
  }
  return measure() ? apart.norm() / std::sqrt(static_cast<double>(turned.size()))
                   : std::numeric_limits<double>::infinity();
}

void refuse_open_lens(const CalibrationProblem& single, const BundleState& state, double sigma_px) {
  const double limit_px = open_limit_px(state.cameras[0].size);
  if (sigma_px <= limit_px) return;
  throw Error(ErrorKind::kNotEnoughData,
              fmt::format("the views leave the lens open: its projection would be known to {:.0f} px only, and beyond "
                          "{:.0f} px (2 % of the image) it is of no use; tilt the board by 20 to 45 degrees in some "
                          "images, hold it near and far and in the corners, or choose a model with fewer parameters",
                          sigma_px, limit_px),
              "camera " + single.cameras[0].name);
}

}  // namespace raybundle
