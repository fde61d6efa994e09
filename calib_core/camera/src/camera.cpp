// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/camera/camera.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace raybundle {
namespace {

template <CameraModel M>
bool reaches(const double* shape, double angle) {
  if constexpr (requires { M::grows_up_to(shape, angle); }) {
    if (M::grows_up_to(shape, angle)) return true;
  }
  return angle <= M::max_angle_rad(shape);
}

}  // namespace

std::optional<ModelId> model_named(std::string_view name) {
  const std::vector<std::string_view> names = model_names();
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) return std::nullopt;
  return ModelId{static_cast<int>(found - names.begin())};
}

std::vector<std::string_view> model_names() {
  std::vector<std::string_view> names;
  Models::for_each([&]<CameraModel M>() { names.push_back(M::kName); });
  return names;
}

std::string_view model_name(ModelId model) {
  return with_model(model, []<CameraModel M>() { return M::kName; });
}

std::vector<std::string_view> parameter_names(ModelId model) {
  std::vector<std::string_view> names{"fx", "fy", "cx", "cy"};
  with_model(model, [&]<CameraModel M>() { names.insert(names.end(), M::kShapeNames.begin(), M::kShapeNames.end()); });
  return names;
}

std::span<const ForeignName> foreign_names(ModelId model) {
  return with_model(model, []<CameraModel M>() { return std::span<const ForeignName>(M::kForeignNames); });
}

Camera start_camera(ModelId model, ImageSize size, double focal_px) {
  return with_model(model, [&]<CameraModel M>() {
    constexpr double kAxis[] = {0.0, 0.0, 1.0};
    double plane[2];
    double plane_wrt_ray[6];
    std::array<double, 2 * kParameterCount<M>> plane_wrt_shape;
    M::plane_from_ray(M::kStartShape.data(), kAxis, plane, plane_wrt_ray, plane_wrt_shape.data());
    const double f = focal_px / plane_wrt_ray[0];  // [0] is the profile's slope on the axis
    Camera camera{model, size, Eigen::VectorXd(kParameterCount<M>)};
    camera.parameters.head<4>() << f, f, 0.5 * (size.width - 1), 0.5 * (size.height - 1);
    for (int k = 0; k < kShapeSize<M>; ++k) camera.parameters[4 + k] = M::kStartShape[k];
    return camera;
  });
}

double angle_off_axis(const Eigen::Vector3d& ray_in_camera) {
  return std::atan2(ray_in_camera.head<2>().norm(), ray_in_camera.z());
}

std::optional<Eigen::Vector2d> pixel_from_ray(const Camera& camera, const Eigen::Vector3d& ray_in_camera) {
  return with_model(camera.model, [&]<CameraModel M>() -> std::optional<Eigen::Vector2d> {
    assert(camera.parameters.size() == kParameterCount<M>);
    if (!reaches<M>(camera.parameters.data() + 4, angle_off_axis(ray_in_camera))) return std::nullopt;
    Eigen::Vector2d pixel;
    if (!pixel_from_ray<M>(camera.parameters.data(), ray_in_camera.data(), pixel.data())) return std::nullopt;
    return pixel;
  });
}

std::optional<Eigen::Vector3d> ray_from_pixel(const Camera& camera, const Eigen::Vector2d& pixel) {
  return with_model(camera.model, [&]<CameraModel M>() -> std::optional<Eigen::Vector3d> {
    assert(camera.parameters.size() == kParameterCount<M>);
    const Eigen::Vector2d plane((pixel.x() - camera.cx()) / camera.fx(), (pixel.y() - camera.cy()) / camera.fy());
    Eigen::Vector3d ray;
    if (!plane.allFinite()) return std::nullopt;
    if (!M::ray_from_plane(camera.parameters.data() + 4, plane.data(), ray.data())) return std::nullopt;
    constexpr double kRounding = 1e-9;  // models keep far within; what overflows on the way has no direction
    if (!(std::abs(ray.squaredNorm() - 1.0) < kRounding)) return std::nullopt;
    return ray;
  });
}

double focal_on_axis_px(const Camera& camera) {
  constexpr double kOff = 1e-3;
  const auto left = pixel_from_ray(camera, Eigen::Vector3d(-kOff, 0, 1));
  const auto right = pixel_from_ray(camera, Eigen::Vector3d(kOff, 0, 1));
  return left && right ? (*right - *left).norm() / (2.0 * kOff) : 0.0;
}

double max_angle_rad(const Camera& camera) {
  return with_model(camera.model, [&]<CameraModel M>() { return M::max_angle_rad(camera.parameters.data() + 4); });
}

}  // namespace raybundle
