// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "calibration_sigma.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "raybundle/geometry/rotation.hpp"
#include "raybundle/scene/parameter_names.hpp"

namespace raybundle {
namespace {

constexpr int kNodes = 13;  // of the grid, along each side

// Parameters of both cameras, in the order in which derivatives stand below.
std::vector<std::string> names_of(const RigCamera& left, const RigCamera& right) {
  std::vector<std::string> names;
  for (const RigCamera* camera : {&left, &right}) {
    std::ranges::copy(intrinsic_names(*camera), std::back_inserter(names));
    std::ranges::copy(extrinsic_names(*camera), std::back_inserter(names));
  }
  return names;
}

double sigma_of(const Eigen::RowVectorXd& by_left, const Eigen::RowVectorXd& by_right,
                const Eigen::MatrixXd& covariance) {
  Eigen::RowVectorXd by_both(by_left.size() + by_right.size());
  by_both << by_left, by_right;
  return std::sqrt(std::max(0.0, (by_both * covariance * by_both.transpose()).value()));
}

// How the distance of two cameras changes with the parameters of the first: intrinsics, rotation as in perturbed(),
// translation. Its centre is -Rᵀ t.
Eigen::RowVectorXd baseline_by(const RigCamera& camera, const RigCamera& other) {
  const Rigid3& place = camera.camera_from_rig;
  const Eigen::Vector3d away = (place.inverse().translation - other.camera_from_rig.inverse().translation).normalized();
  const Eigen::RowVector3d along = (place.rotation * away).transpose();  // in the camera
  Eigen::RowVectorXd by = Eigen::RowVectorXd::Zero(camera.camera.parameters.size() + 6);
  by.tail(6).head<3>() = -along * skew(place.translation);
  by.tail(3) = -along;
  return by;
}

// How a function of the ray that lands on a pixel changes with the parameters of its camera, in the same order: the ray
// moves as the pixel stays. Nothing where the lens folds.
std::optional<Eigen::RowVectorXd> by_parameters_of(const RigCamera& rig_camera, const Eigen::Vector3d& ray_in_camera,
                                                   const Eigen::RowVector3d& by_ray) {
  const Camera& camera = rig_camera.camera;
  Eigen::Matrix<double, 3, 2> across;  // the ray
  across.col(0) = ray_in_camera.unitOrthogonal();
  across.col(1) = ray_in_camera.cross(across.col(0));
  Eigen::RowVectorXd by = Eigen::RowVectorXd::Zero(camera.parameters.size() + 6);
  with_model(camera.model, [&]<CameraModel M>() {
    Eigen::Vector2d pixel;
    Eigen::Matrix<double, 2, 3, Eigen::RowMajor> pixel_by_ray;
    Eigen::Matrix<double, 2, kParameterCount<M>, Eigen::RowMajor> pixel_by_parameters;
    if (!pixel_from_ray<M>(camera.parameters.data(), ray_in_camera, pixel, pixel_by_ray, pixel_by_parameters)) return;
    const Eigen::Matrix2d pixel_by_across = pixel_by_ray * across;
    by.head(camera.parameters.size()) = -by_ray * across * pixel_by_across.inverse() * pixel_by_parameters;
  });
  by.tail(6).head<3>() = by_ray * skew(ray_in_camera);  // the camera turns, and its rays with it
  if (!by.allFinite()) return std::nullopt;
  return by;
}

// How the column of the rectified image changes with a ray of a camera.
std::optional<Eigen::RowVector3d> column_by_ray(const RectifiedCamera& rectified,
                                                const Eigen::Quaterniond& rectified_from_camera,
                                                const Eigen::Vector3d& ray_in_camera) {
  constexpr double kStep = 1e-6;  // of central differences of a smooth function of a unit vector
  Eigen::RowVector3d by_ray;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(i);
    const auto before = rectified.pixel_from_ray(rectified_from_camera * (ray_in_camera - step));
    const auto after = rectified.pixel_from_ray(rectified_from_camera * (ray_in_camera + step));
    if (!before || !after) return std::nullopt;
    by_ray[i] = (after->x() - before->x()) / (2.0 * kStep);
  }
  return by_ray;
}

// How the column at which a camera sees its pixel changes with its parameters.
std::optional<Eigen::RowVectorXd> column_by(const RigCamera& camera, const Rectification& pair,
                                            const Eigen::Vector3d& ray_in_rectified) {
  const Eigen::Quaterniond rectified_from_camera =
      pair.rig_from_rectified.rotation.conjugate() * camera.camera_from_rig.rotation.conjugate();
  const Eigen::Vector3d ray_in_camera = (rectified_from_camera.conjugate() * ray_in_rectified).normalized();
  if (!pixel_from_ray(camera.camera, ray_in_camera)) return std::nullopt;
  const auto by_ray = column_by_ray(pair.camera, rectified_from_camera, ray_in_camera);
  return by_ray ? by_parameters_of(camera, ray_in_camera, *by_ray) : std::nullopt;
}

// Sigma of the disparity at a pixel of the rectified image; nothing where one of the cameras sees nothing.
std::optional<double> disparity_sigma(const Eigen::MatrixXd& covariance, const RigCamera& left, const RigCamera& right,
                                      const Rectification& pair, const Eigen::Vector2d& rectified_pixel) {
  const auto ray = pair.camera.ray_from_pixel(rectified_pixel);
  if (!ray) return std::nullopt;
  const auto by_left = column_by(left, pair, *ray), by_right = column_by(right, pair, *ray);
  if (!by_left || !by_right) return std::nullopt;
  return sigma_of(*by_left, -*by_right, covariance);
}

// At every pixel, from the nodes of a grid over the image.
std::vector<float> interpolated(const Eigen::MatrixXd& nodes, ImageSize size) {
  std::vector<float> values(static_cast<std::size_t>(size.width) * size.height);
  for (int v = 0; v < size.height; ++v) {
    const double y = v * (kNodes - 1.0) / (size.height - 1.0);
    const int j = std::min(static_cast<int>(y), kNodes - 2);
    for (int u = 0; u < size.width; ++u) {
      const double x = u * (kNodes - 1.0) / (size.width - 1.0);
      const int i = std::min(static_cast<int>(x), kNodes - 2);
      const double top = (1 - (x - i)) * nodes(j, i) + (x - i) * nodes(j, i + 1);
      const double bottom = (1 - (x - i)) * nodes(j + 1, i) + (x - i) * nodes(j + 1, i + 1);
      values[static_cast<std::size_t>(v) * size.width + u] = static_cast<float>((1 - (y - j)) * top + (y - j) * bottom);
    }
  }
  return values;
}

}  // namespace

CalibrationSigma calibration_sigma(const Covariance& covariance, const RigCamera& left, const RigCamera& right,
                                   const Rectification& pair) {
  const Eigen::MatrixXd of_both = covariance.block(names_of(left, right));
  const ImageSize size = pair.camera.size;
  CalibrationSigma sigma;
  sigma.relative_baseline = sigma_of(baseline_by(left, right), baseline_by(right, left), of_both) / pair.baseline_m;
  Eigen::MatrixXd nodes(kNodes, kNodes);
  for (int row = 0; row < kNodes; ++row) {
    for (int column = 0; column < kNodes; ++column) {
      const Eigen::Vector2d pixel(column * (size.width - 1.0) / (kNodes - 1), row * (size.height - 1.0) / (kNodes - 1));
      nodes(row, column) = disparity_sigma(of_both, left, right, pair, pixel).value_or(-1.0);
    }
  }
  // Where one of the cameras sees nothing there is nothing to match; the largest stands in so that rims interpolate.
  const double largest = std::max(0.0, nodes.maxCoeff());
  nodes = (nodes.array() < 0.0).select(largest, nodes);
  sigma.disparity_sigma_px = interpolated(nodes, size);
  return sigma;
}

}  // namespace raybundle
