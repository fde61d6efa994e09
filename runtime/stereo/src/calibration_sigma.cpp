// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "calibration_sigma.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "raybundle/scene/parameter_names.hpp"

namespace raybundle {
namespace {

constexpr int kNodes = 13;  // of the grid, along each side

// A parameter of one of the two cameras: an intrinsic, or a component of perturbed()'s motion.
struct Parameter {
  bool left = false;
  std::optional<Eigen::Index> intrinsic, motion;
  double step = 0.0;  // for differences; 0: not estimated
};

// Those of both cameras, in the order of their names.
struct Parameters {
  std::vector<Parameter> list;
  Eigen::MatrixXd covariance;
};

Parameters parameters_of(const Covariance& covariance, const RigCamera& left, const RigCamera& right) {
  constexpr double kStepSigmas = 0.1;
  Parameters parameters;
  std::vector<std::string> names;
  for (const RigCamera* camera : {&left, &right}) {
    std::ranges::copy(intrinsic_names(*camera), std::back_inserter(names));
    for (Eigen::Index i = 0; i < camera->camera.parameters.size(); ++i) {
      parameters.list.push_back({.left = camera == &left, .intrinsic = i, .motion = {}});
    }
    std::ranges::copy(extrinsic_names(*camera), std::back_inserter(names));
    for (Eigen::Index i = 0; i < 6; ++i) {
      parameters.list.push_back({.left = camera == &left, .intrinsic = {}, .motion = i});
    }
  }
  parameters.covariance = covariance.block(names);
  for (Eigen::Index i = 0; i < std::ssize(names); ++i) {
    parameters.list[static_cast<std::size_t>(i)].step =
        kStepSigmas * std::sqrt(std::max(parameters.covariance(i, i), 0.0));
  }
  return parameters;
}

// A camera with one parameter a step away.
RigCamera moved(RigCamera camera, const Parameter& parameter) {
  if (parameter.intrinsic) {
    camera.camera.parameters[*parameter.intrinsic] += parameter.step;
  } else {
    const Eigen::Matrix<double, 6, 1> motion = parameter.step * Eigen::Matrix<double, 6, 1>::Unit(*parameter.motion);
    camera.camera_from_rig = perturbed(camera.camera_from_rig, motion);
  }
  return camera;
}

// Sigma of what depends on the parameters.
//
// @param change  of it with one parameter's step
template <typename Change>
double sigma_of(const Parameters& parameters, const Change& change) {
  Eigen::RowVectorXd by_parameters = Eigen::RowVectorXd::Zero(std::ssize(parameters.list));
  for (Eigen::Index i = 0; i < by_parameters.size(); ++i) {
    const Parameter& parameter = parameters.list[static_cast<std::size_t>(i)];
    if (parameter.step > 0.0) by_parameters[i] = change(parameter) / parameter.step;
  }
  return std::sqrt(std::max(0.0, (by_parameters * parameters.covariance * by_parameters.transpose()).value()));
}

double baseline(const RigCamera& a, const RigCamera& b) {
  return (a.camera_from_rig.inverse().translation - b.camera_from_rig.inverse().translation).norm();
}

// The column of the rectified image at which a camera, believed to be as given, sees its pixel.
std::optional<double> column_of(const RectifiedCamera& rectified, const Eigen::Quaterniond& rectified_from_rig,
                                const RigCamera& camera, const Eigen::Vector2d& pixel) {
  const auto ray = ray_from_pixel(camera.camera, pixel);
  if (!ray) return std::nullopt;
  const auto at = rectified.pixel_from_ray(rectified_from_rig * (camera.camera_from_rig.rotation.conjugate() * *ray));
  if (!at) return std::nullopt;
  return at->x();
}

// Sigma of the disparity at a pixel of the rectified image; nothing where one of the cameras sees nothing.
std::optional<double> disparity_sigma(const Parameters& parameters, const RigCamera& left, const RigCamera& right,
                                      const Rectification& pair, const Eigen::Vector2d& rectified_pixel) {
  const auto ray = pair.camera.ray_from_pixel(rectified_pixel);
  if (!ray) return std::nullopt;
  const auto left_pixel = pixel_from_ray(left.camera, pair.rectified_from_left.conjugate() * *ray);
  const auto right_pixel = pixel_from_ray(right.camera, pair.rectified_from_right.conjugate() * *ray);
  if (!left_pixel || !right_pixel) return std::nullopt;
  const Eigen::Quaterniond rectified_from_rig = pair.rig_from_rectified.rotation.conjugate();
  return sigma_of(parameters, [&](const Parameter& parameter) {
    const auto at = column_of(pair.camera, rectified_from_rig, moved(parameter.left ? left : right, parameter),
                              parameter.left ? *left_pixel : *right_pixel);
    return at ? (parameter.left ? 1.0 : -1.0) * (*at - rectified_pixel.x()) : 0.0;
  });
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
  const Parameters parameters = parameters_of(covariance, left, right);
  const ImageSize size = pair.camera.size;
  CalibrationSigma sigma;
  sigma.relative_baseline = sigma_of(parameters,
                                     [&](const Parameter& parameter) {
                                       const double changed = parameter.left ? baseline(moved(left, parameter), right)
                                                                             : baseline(left, moved(right, parameter));
                                       return changed - pair.baseline_m;
                                     }) /
                            pair.baseline_m;
  Eigen::MatrixXd nodes(kNodes, kNodes);
  for (int row = 0; row < kNodes; ++row) {
    for (int column = 0; column < kNodes; ++column) {
      const Eigen::Vector2d pixel(column * (size.width - 1.0) / (kNodes - 1), row * (size.height - 1.0) / (kNodes - 1));
      nodes(row, column) = disparity_sigma(parameters, left, right, pair, pixel).value_or(-1.0);
    }
  }
  // Where one of the cameras sees nothing there is nothing to match; the largest stands in so that rims interpolate.
  const double largest = std::max(0.0, nodes.maxCoeff());
  nodes = (nodes.array() < 0.0).select(largest, nodes);
  sigma.disparity_sigma_px = interpolated(nodes, size);
  return sigma;
}

}  // namespace raybundle
