// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <concepts>
#include <span>
#include <string_view>

#include "raybundle/camera/lanes.hpp"

namespace raybundle {

/// What a camera model is called in another program's files.
struct ForeignName {
  std::string_view
      format;  ///< opencv, opencv_fisheye, opencv_omnidir, mrcal, kalibr, ros, basalt, colmap, camodocal, ...
  std::string_view name;  ///< the name in that format
};

/// A coefficient that the others of a lens can nearly replace, and what is known of it before any corner is seen.
struct ExpectedCoefficient {
  std::string_view name;
  double value;
  double sigma;
};

/// A realistic camera of a model, for the law tests: shape parameters and the half field of view they are good for.
template <int shape_size>
struct ExampleShape {
  std::array<double, static_cast<std::size_t>(shape_size)> shape;
  double half_angle_rad;  ///< the law tests use rays up to this angle off the axis
};

/// A camera model maps a ray to the image plane at unit focal length; pixel = (fx x + cx, fy y + cy) is common to all
/// (camera.hpp). A model is a stateless struct in a file of its own in camera/models/:
///
/// ```
/// kName                     file, type and this name agree: kannala_brandt, KannalaBrandt
/// kShapeNames               parameters after fx fy cx cy, in file order
/// kStartShape               a neutral start: the shape of an undistorted lens of its kind
/// kExamples                 ExampleShape<n>{...}, ...
/// kForeignNames             ForeignName{...}, ...
/// kExpected                 ExpectedCoefficient{...}, ...; only where there are such coefficients
///
/// template <typename T>     any number: double, Lanes, ceres::Jet, ...
/// static bool plane_from_ray(const T* shape, const T* ray, T* plane);
///                           ray: any nonzero 3-vector, its length does not matter; false where the model does not
///                           project the ray
///
/// template <typename T>     double or Lanes: start and bundle take several corners at once
/// static bool plane_from_ray(const T* shape, const T* ray, T* plane, T* plane_wrt_ray, T* plane_wrt_shape);
///                           the same with analytic Jacobians, 2×3 and 2×n row-major
///
/// static bool ray_from_plane(const double* shape, const double* plane, double* ray);
///                           unit vector, exact to 1e-12; false where no ray projects to the point
///
/// static double max_angle_rad(const double* shape);
///                           half-angle up to which the radial profile is increasing (the model is injective), at
///                           most pi
///
/// static bool grows_up_to(const double* shape, double angle);
///                           only where max_angle_rad takes a search: whether the profile is increasing up to the
///                           angle; quick, and false when that is not plain
/// ```
template <typename M>
concept CameraModel = requires(const double* shape, const double* in, double* out, const Lanes* four, Lanes* of_four) {
  { M::kName } -> std::convertible_to<std::string_view>;
  { M::kShapeNames.size() } -> std::convertible_to<std::size_t>;
  requires M::kShapeNames.size() == M::kStartShape.size();
  { M::kExamples.size() } -> std::convertible_to<std::size_t>;
  {std::span<const ForeignName>(M::kForeignNames)};
  { M::template plane_from_ray<double>(shape, in, out) } -> std::same_as<bool>;
  { M::template plane_from_ray<double>(shape, in, out, out, out) } -> std::same_as<bool>;
  { M::template plane_from_ray<Lanes>(four, four, of_four) } -> std::same_as<bool>;
  { M::template plane_from_ray<Lanes>(four, four, of_four, of_four, of_four) } -> std::same_as<bool>;
  { M::ray_from_plane(shape, in, out) } -> std::same_as<bool>;
  { M::max_angle_rad(shape) } -> std::same_as<double>;
};

/// Number of shape parameters of a model; it has 4 more: fx fy cx cy.
template <CameraModel M>
inline constexpr int kShapeSize = static_cast<int>(M::kShapeNames.size());

template <CameraModel M>
inline constexpr int kParameterCount = 4 + kShapeSize<M>;

}  // namespace raybundle
