// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "calibration_sigma.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

namespace raybundle {
namespace {

constexpr int kNodes = 13;  // of the grid, along each side

// A parameter of the calibration that one of the two cameras has.
struct Parameter {
  Eigen::Index index;  // in the covariance
  bool left;
  int own;     // index into Camera::parameters, or -1
  int motion;  // 0..5 of perturbed(), or -1
};

std::optional<Parameter> parameter_of(const std::string& name, Eigen::Index index, const RigCamera& camera, bool left) {
  if (name.rfind(camera.name + ".", 0) != 0) return std::nullopt;
  const std::string own = name.substr(camera.name.size() + 1);
  const auto names = parameter_names(camera.camera.model);
  const auto found = std::find(names.begin(), names.end(), own);
  if (found != names.end()) return Parameter{index, left, static_cast<int>(found - names.begin()), -1};
  constexpr std::array<std::string_view, 6> kMotion{"camera_from_rig.rotation_x",    "camera_from_rig.rotation_y",
                                                    "camera_from_rig.rotation_z",    "camera_from_rig.translation_x",
                                                    "camera_from_rig.translation_y", "camera_from_rig.translation_z"};
  const auto motion = std::find(kMotion.begin(), kMotion.end(), own);
  if (motion != kMotion.end()) return Parameter{index, left, -1, static_cast<int>(motion - kMotion.begin())};
  return std::nullopt;
}

RigCamera moved(RigCamera camera, const Parameter& parameter, double step) {
  if (parameter.own >= 0) {
    camera.camera.parameters[parameter.own] += step;
  } else {
    Eigen::Matrix<double, 6, 1> motion = Eigen::Matrix<double, 6, 1>::Zero();
    motion[parameter.motion] = step;
    camera.camera_from_rig = perturbed(camera.camera_from_rig, motion);
  }
  return camera;
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

}  // namespace

CalibrationSigma calibration_sigma(const Covariance& covariance, const RigCamera& left, const RigCamera& right,
                                   const Rectification& pair) {
  CalibrationSigma sigma;
  const ImageSize size = pair.camera.size;
  sigma.disparity_sigma_px.assign(static_cast<std::size_t>(size.width) * size.height, 0.0F);
  std::vector<Parameter> parameters;
  for (std::size_t i = 0; i < covariance.names.size(); ++i) {
    for (const bool is_left : {true, false}) {
      const auto parameter =
          parameter_of(covariance.names[i], static_cast<Eigen::Index>(i), is_left ? left : right, is_left);
      if (parameter) parameters.push_back(*parameter);
    }
  }
  if (parameters.empty()) return sigma;

  const auto count = static_cast<Eigen::Index>(parameters.size());
  Eigen::MatrixXd joint(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = 0; j < count; ++j) {
      joint(i, j) = covariance.matrix(parameters[static_cast<std::size_t>(i)].index,
                                      parameters[static_cast<std::size_t>(j)].index);
    }
  }
  const auto step_of = [&](Eigen::Index i) { return 0.1 * std::sqrt(std::max(joint(i, i), 0.0)); };

  const Eigen::Quaterniond rectified_from_rig = pair.rig_from_rectified.rotation.conjugate();
  const auto baseline = [](const RigCamera& a, const RigCamera& b) {
    return (a.camera_from_rig.inverse().translation - b.camera_from_rig.inverse().translation).norm();
  };
  Eigen::RowVectorXd baseline_wrt = Eigen::RowVectorXd::Zero(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Parameter& parameter = parameters[static_cast<std::size_t>(i)];
    if (!(step_of(i) > 0)) continue;
    const double changed = parameter.left ? baseline(moved(left, parameter, step_of(i)), right)
                                          : baseline(left, moved(right, parameter, step_of(i)));
    baseline_wrt[i] = (changed - pair.baseline_m) / step_of(i);
  }
  sigma.relative_baseline =
      std::sqrt(std::max(0.0, (baseline_wrt * joint * baseline_wrt.transpose()).value())) / pair.baseline_m;

  Eigen::MatrixXd nodes = Eigen::MatrixXd::Constant(kNodes, kNodes, -1.0);
  for (int row = 0; row < kNodes; ++row) {
    for (int column = 0; column < kNodes; ++column) {
      const Eigen::Vector2d rectified_pixel(column * (size.width - 1.0) / (kNodes - 1),
                                            row * (size.height - 1.0) / (kNodes - 1));
      const auto ray = pair.camera.ray_from_pixel(rectified_pixel);
      if (!ray) continue;
      const auto left_pixel = pixel_from_ray(left.camera, pair.rectified_from_left.conjugate() * *ray);
      const auto right_pixel = pixel_from_ray(right.camera, pair.rectified_from_right.conjugate() * *ray);
      if (!left_pixel || !right_pixel) continue;
      Eigen::RowVectorXd disparity_wrt = Eigen::RowVectorXd::Zero(count);
      for (Eigen::Index i = 0; i < count; ++i) {
        const Parameter& parameter = parameters[static_cast<std::size_t>(i)];
        if (!(step_of(i) > 0)) continue;
        const auto at =
            column_of(pair.camera, rectified_from_rig, moved(parameter.left ? left : right, parameter, step_of(i)),
                      parameter.left ? *left_pixel : *right_pixel);
        if (at) disparity_wrt[i] = (parameter.left ? 1.0 : -1.0) * (*at - rectified_pixel.x()) / step_of(i);
      }
      nodes(row, column) = std::sqrt(std::max(0.0, (disparity_wrt * joint * disparity_wrt.transpose()).value()));
    }
  }
  // Where one of the cameras sees nothing there is nothing to match; the largest stands in so that rims interpolate.
  const double largest = nodes.maxCoeff();
  for (int v = 0; v < size.height; ++v) {
    const double y = v * (kNodes - 1.0) / (size.height - 1.0);
    const int j = std::min(static_cast<int>(y), kNodes - 2);
    for (int u = 0; u < size.width; ++u) {
      const double x = u * (kNodes - 1.0) / (size.width - 1.0);
      const int i = std::min(static_cast<int>(x), kNodes - 2);
      const auto node = [&](int dj, int di) { return nodes(j + dj, i + di) < 0 ? largest : nodes(j + dj, i + di); };
      const double top = (1 - (x - i)) * node(0, 0) + (x - i) * node(0, 1);
      const double bottom = (1 - (x - i)) * node(1, 0) + (x - i) * node(1, 1);
      sigma.disparity_sigma_px[static_cast<std::size_t>(v) * size.width + u] =
          static_cast<float>(std::max(0.0, (1 - (y - j)) * top + (y - j) * bottom));
    }
  }
  return sigma;
}

}  // namespace raybundle
