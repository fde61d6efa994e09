// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "raybundle/camera/camera_model.hpp"
#include "raybundle/camera/model_list.hpp"

namespace raybundle {

/// Which camera model: an index into `Models`.
struct ModelId {
  int index = 0;
  friend bool operator==(ModelId, ModelId) = default;
};

/// The model of that name; nothing when there is none.
std::optional<ModelId> model_named(std::string_view name);

/// Names of all models, in list order.
std::vector<std::string_view> model_names();

std::string_view model_name(ModelId model);

/// fx, fy, cx, cy, then the shape parameters, in the order of Camera::parameters.
std::vector<std::string_view> parameter_names(ModelId model);

/// What the model is called elsewhere.
std::span<const ForeignName> foreign_names(ModelId model);

/// Calls function.operator()<Model>() for the model with that id: the choice is made once, outside of the loops.
template <typename Function>
decltype(auto) with_model(ModelId model, Function&& function) {
  return [&]<std::size_t... index>(std::index_sequence<index...>)->decltype(auto) {
    using Result = decltype(function.template operator()<Models::At<0>>());
    using Call = Result (*)(Function&);
    static constexpr Call calls[] = {
        +[](Function& f) -> Result { return f.template operator()<Models::At<index>>(); }...};
    return calls[model.index](function);
  }
  (std::make_index_sequence<Models::kSize>());
}

/// Size of an image [px].
struct ImageSize {
  int width = 0;
  int height = 0;
  friend bool operator==(ImageSize, ImageSize) = default;

  /// The image covers its pixels to their edges: -0.5 <= u < width - 0.5, and so for v; see docs/conventions.md.
  bool contains(const Eigen::Vector2d& pixel) const {
    return pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() < width - 0.5 && pixel.y() < height - 0.5;
  }
};

/// A calibrated camera. `parameters` has as many entries as parameter_names(model).
struct Camera {
  ModelId model;
  ImageSize size;
  Eigen::VectorXd parameters;  ///< fx fy cx cy [px], then the model's shape

  double fx() const { return parameters[0]; }
  double fy() const { return parameters[1]; }
  double cx() const { return parameters[2]; }
  double cy() const { return parameters[3]; }
};

/// A camera with the model's neutral shape, square pixels and the principal point at the image centre.
///
/// @param focal_px  focal length [px]: slope of radius against angle on the axis
Camera start_camera(ModelId model, ImageSize size, double focal_px);

/// Angle [rad] between a ray of any length except zero and the optical axis, 0 to pi.
double angle_off_axis(const Eigen::Vector3d& ray_in_camera);

/// Pixel where a ray lands; nothing where the model does not project it or folds back (beyond max_angle_rad), so that
/// every answer is undone by ray_from_pixel.
///
/// @param ray_in_camera  3-vector of any length except zero; beyond 90° off the axis is ordinary
std::optional<Eigen::Vector2d> pixel_from_ray(const Camera& camera, const Eigen::Vector3d& ray_in_camera);

/// Unit ray that lands on a pixel; nothing where no ray does.
std::optional<Eigen::Vector3d> ray_from_pixel(const Camera& camera, const Eigen::Vector2d& pixel);

/// Pixels for each radian off the axis, along x: what fx is to models that leave the axis as a pinhole has it. 0 where
/// the camera does not project.
double focal_on_axis_px(const Camera& camera);

/// Half-angle [rad] up to which the camera's radial profile is increasing, at most pi.
double max_angle_rad(const Camera& camera);

/// Pixel of a ray for a model known at compile time; `parameters` as in Camera. The hot loop of the bundle: rays beyond
/// max_angle_rad are not refused.
template <CameraModel M, typename T>
bool pixel_from_ray(const T* parameters, const T* ray, T* pixel) {
  T plane[2];
  if (!M::plane_from_ray(parameters + 4, ray, plane)) return false;
  pixel[0] = parameters[0] * plane[0] + parameters[2];
  pixel[1] = parameters[1] * plane[1] + parameters[3];
  return true;
}

/// Pixel of a ray with Jacobians, for a model known at compile time.
///
/// @param pixel_wrt_ray         2×3
/// @param pixel_wrt_parameters  2×n, columns as in Camera::parameters
template <CameraModel M>
bool pixel_from_ray(const double* parameters, const Eigen::Vector3d& ray, Eigen::Vector2d& pixel,
                    Eigen::Matrix<double, 2, 3, Eigen::RowMajor>& pixel_wrt_ray,
                    Eigen::Matrix<double, 2, kParameterCount<M>, Eigen::RowMajor>& pixel_wrt_parameters) {
  constexpr int n = kShapeSize<M>;
  double plane[2];
  double plane_wrt_shape[n > 0 ? 2 * n : 1];
  if (!M::plane_from_ray(parameters + 4, ray.data(), plane, pixel_wrt_ray.data(), plane_wrt_shape)) return false;
  pixel_wrt_parameters.setZero();
  for (int axis = 0; axis < 2; ++axis) {
    const double focal = parameters[axis];
    pixel[axis] = focal * plane[axis] + parameters[2 + axis];
    pixel_wrt_ray.row(axis) *= focal;
    pixel_wrt_parameters(axis, axis) = plane[axis];
    pixel_wrt_parameters(axis, 2 + axis) = 1.0;
    for (int k = 0; k < n; ++k) pixel_wrt_parameters(axis, 4 + k) = focal * plane_wrt_shape[axis * n + k];
  }
  return true;
}

}  // namespace raybundle
