// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/camera/camera.hpp"

#include <algorithm>
#include <cassert>

namespace raybundle {

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
    Camera camera{model, size, Eigen::VectorXd(kParameterCount<M>)};
    camera.parameters.head<4>() << focal_px, focal_px, 0.5 * (size.width - 1), 0.5 * (size.height - 1);
    for (int k = 0; k < kShapeSize<M>; ++k) camera.parameters[4 + k] = M::kStartShape[k];
    return camera;
  });
}

std::optional<Eigen::Vector2d> pixel_from_ray(const Camera& camera, const Eigen::Vector3d& ray_in_camera) {
  return with_model(camera.model, [&]<CameraModel M>() -> std::optional<Eigen::Vector2d> {
    assert(camera.parameters.size() == kParameterCount<M>);
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
    if (!M::ray_from_plane(camera.parameters.data() + 4, plane.data(), ray.data())) return std::nullopt;
    return ray;
  });
}

double max_angle_rad(const Camera& camera) {
  return with_model(camera.model,
                    [&]<CameraModel M>() { return M::max_angle_rad(camera.parameters.data() + 4); });
}

}  // namespace raybundle
