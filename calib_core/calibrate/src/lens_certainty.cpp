// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "lens_certainty.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "local_optima.hpp"
#include "raybundle/bundle/information.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/rotation.hpp"
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

double projection_sigma_px(const CalibrationProblem& single, const BundleState& state, int threads) {
  const Camera& camera = state.cameras[0];
  const std::vector<Eigen::Vector3d> rays = rays_seen(single, state);
  if (rays.empty()) return 0.0;
  BundleOptions bundle;
  bundle.threads = threads;
  const CovarianceResult known = covariance(reduced_information(single, state, bundle));
  const Slopes slopes = slopes_of(camera, rays);
  // Columns of the intrinsics that were estimated, in the order of the covariance; others are known.
  const std::vector<std::string_view> names = parameter_names(camera.model);
  const auto count = static_cast<Eigen::Index>(known.covariance.names.size());
  Eigen::MatrixXd by_estimated = Eigen::MatrixXd::Zero(slopes.by_turn.rows(), count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const std::string& name = known.covariance.names[static_cast<std::size_t>(k)];
    const auto found = std::ranges::find_if(names, [&](std::string_view parameter) {
      return name == single.cameras[0].name + "." + std::string(parameter);
    });
    if (found != names.end()) by_estimated.col(k) = slopes.by_parameters.col(found - names.begin());
  }
  by_estimated -= slopes.by_turn * slopes.by_turn.colPivHouseholderQr().solve(by_estimated);
  const double sum = (by_estimated * known.covariance.matrix).cwiseProduct(by_estimated).sum();
  return std::sqrt(std::max(0.0, sum) / static_cast<double>(rays.size()));
}

bool leaves_lens_open(ImageSize size, double sigma_px) { return sigma_px > open_limit_px(size); }

void refuse_open_lens(const CalibrationProblem& single, const BundleState& state, double sigma_px) {
  const ImageSize size = state.cameras[0].size;
  if (!leaves_lens_open(size, sigma_px)) return;
  throw Error(ErrorKind::kNotEnoughData,
              fmt::format("the views leave the lens open: its projection would be known to {:.0f} px only, and beyond "
                          "{:.0f} px (2 % of the image) it is of no use; tilt the board by 20 to 45 degrees in some "
                          "images, hold it near and far and in the corners, or choose a model with fewer parameters",
                          sigma_px, open_limit_px(size)),
              "camera " + single.cameras[0].name);
}

}  // namespace raybundle
