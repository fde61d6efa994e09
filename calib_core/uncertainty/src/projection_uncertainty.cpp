// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/projection_uncertainty.hpp"

#include <algorithm>
#include <cmath>

#include "motion_fit.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/uncertainty/image_cells.hpp"
#include "sensitivity.hpp"

namespace raybundle {

ProjectionUncertainty projection_uncertainty(const RigCamera& camera, const Covariance& covariance) {
  if (!camera.evidence) {
    throw Error(ErrorKind::kBadInput,
                "the calibration does not tell where the corners of camera " + camera.name +
                    " were, so that its uncertainty cannot be told either; take one that was solved from corners");
  }
  return {camera.camera, covariance.block(intrinsic_names(camera)), camera.evidence->implied_motion};
}

std::optional<Eigen::Matrix2Xd> projection_derivatives(const ProjectionUncertainty& uncertainty,
                                                       const Eigen::Vector2d& pixel, double range_m) {
  const std::optional<Eigen::Vector3d> ray = ray_from_pixel(uncertainty.camera, pixel);
  if (!ray) return std::nullopt;
  const std::optional<PixelDerivatives> derivatives = pixel_derivatives(uncertainty.camera, *ray);
  if (!derivatives) return std::nullopt;
  return derivatives->by_intrinsics + by_motion_at(derivatives->by_ray, *ray, range_m) * uncertainty.implied_motion;
}

std::optional<Eigen::Matrix2d> projection_covariance(const ProjectionUncertainty& uncertainty,
                                                     const Eigen::Vector2d& pixel, double range_m) {
  const std::optional<Eigen::Matrix2Xd> by_parameters = projection_derivatives(uncertainty, pixel, range_m);
  if (!by_parameters) return std::nullopt;
  return *by_parameters * uncertainty.covariance * by_parameters->transpose();
}

double largest_sigma(const Eigen::Matrix2d& covariance) {
  const double mean = 0.5 * covariance.trace();
  const double spread = std::hypot(0.5 * (covariance(0, 0) - covariance(1, 1)), covariance(0, 1));
  return std::sqrt(std::max(0.0, mean + spread));
}

Eigen::Vector2d UncertaintyMap::pixel(Eigen::Index row, Eigen::Index column) const {
  return middle_of_cell(size, static_cast<int>(sigma_px.rows()), static_cast<int>(sigma_px.cols()),
                        static_cast<int>(row), static_cast<int>(column));
}

UncertaintyMap uncertainty_map(const ProjectionUncertainty& uncertainty, double range_m, int columns) {
  return uncertainty_map(std::span(&uncertainty, 1), range_m, columns);
}

UncertaintyMap uncertainty_map(std::span<const ProjectionUncertainty> of_camera, double range_m, int columns) {
  const ImageSize size = of_camera.front().camera.size;
  UncertaintyMap map{size, range_m, {}};
  map.sigma_px.resize(rows_of_square_cells(size, columns), columns);
  for (Eigen::Index row = 0; row < map.sigma_px.rows(); ++row) {
    for (Eigen::Index column = 0; column < columns; ++column) {
      const auto by_parameters = projection_derivatives(of_camera.front(), map.pixel(row, column), range_m);
      double sigma_px = std::nan("");
      for (const ProjectionUncertainty& each : of_camera) {
        if (!by_parameters) break;
        const double sigma = largest_sigma(*by_parameters * each.covariance * by_parameters->transpose());
        if (!(sigma_px >= sigma)) sigma_px = sigma;
      }
      map.sigma_px(row, column) = sigma_px;
    }
  }
  return map;
}

}  // namespace raybundle
