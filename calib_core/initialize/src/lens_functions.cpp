// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "lens_functions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "raybundle/camera/lanes.hpp"
#include "raybundle/geometry/gram.hpp"
#include "raybundle/geometry/target_clones.hpp"
#include "start_lens.hpp"

namespace raybundle {
namespace {

constexpr double kLeastWeight = 1e-6;  ///< of a corner that is far off: below, it does not count

template <CameraModel M>
bool project(const double* parameters, const Eigen::Vector3d& ray, Eigen::Vector2d& pixel) {
  return pixel_from_ray<M>(parameters, ray.data(), pixel.data());
}

template <CameraModel M>
bool project_with_jacobians(const double* parameters, const Eigen::Vector3d& ray, Eigen::Vector2d& pixel,
                            Eigen::Matrix<double, 2, 3, Eigen::RowMajor>& wrt_ray, double* wrt_parameters) {
  Eigen::Matrix<double, 2, kParameterCount<M>, Eigen::RowMajor> jacobian;
  if (!pixel_from_ray<M>(parameters, ray, pixel, wrt_ray, jacobian)) return false;
  Eigen::Map<Eigen::Matrix<double, 2, kParameterCount<M>, Eigen::RowMajor>> out(wrt_parameters);
  out = jacobian;
  return true;
}

template <CameraModel M>
bool unproject(const double* parameters, const Eigen::Vector2d& pixel, Eigen::Vector3d& ray) {
  const double plane[2] = {(pixel.x() - parameters[2]) / parameters[0], (pixel.y() - parameters[3]) / parameters[1]};
  return M::ray_from_plane(parameters + 4, plane, ray.data());
}

template <CameraModel M, typename Number>
struct Shape {
  Number values[kShapeSize<M> > 0 ? kShapeSize<M> : 1];
  [[gnu::always_inline]] explicit Shape(const double* parameters) {
    for (int k = 0; k < kShapeSize<M>; ++k) values[k] = Number(parameters[4 + k]);
  }
};

/// Rays of as many pixels as there are lanes, by Newton's method on what the model projects; false where it does not
/// get there.
template <CameraModel M>
[[gnu::always_inline]] inline bool find_rays(const double* parameters, const Eigen::Vector2d* pixels,
                                             Eigen::Vector3d* rays) {
  constexpr int kMostSteps = 8;
  constexpr double kNear = 1e-6;  // of the plane: what the next step leaves is the square of it
  const Shape<M, Lanes> shape(parameters);
  Lanes pixel[2], target[2], plane[2], slope[6], wrt_shape[kShapeSize<M> > 0 ? 2 * kShapeSize<M> : 1];
  load(pixels, pixel);
  for (int axis = 0; axis < 2; ++axis) target[axis] = (pixel[axis] - parameters[2 + axis]) / parameters[axis];
  // A stereographic lens has a ray for every pixel, and is neither much wider nor much narrower than any other.
  Lanes ray[3] = {target[0], target[1], 1.0 - 0.25 * (target[0] * target[0] + target[1] * target[1])};
  bool near = false;
  for (int step = 0; !near && step < kMostSteps; ++step) {
    if (!M::plane_from_ray(shape.values, ray, plane, slope, wrt_shape)) return false;
    const Lanes error[2] = {target[0] - plane[0], target[1] - plane[1]};
    near = (error[0] * error[0] + error[1] * error[1]).sum() < kNear * kNear;
    // The shortest step: along the length of the ray nothing changes.
    const Lanes a = slope[0] * slope[0] + slope[1] * slope[1] + slope[2] * slope[2];
    const Lanes b = slope[0] * slope[3] + slope[1] * slope[4] + slope[2] * slope[5];
    const Lanes c = slope[3] * slope[3] + slope[4] * slope[4] + slope[5] * slope[5];
    const Lanes inverse = 1.0 / (a * c - b * b);
    const Lanes u = inverse * (c * error[0] - b * error[1]), v = inverse * (a * error[1] - b * error[0]);
    for (int k = 0; k < 3; ++k) ray[k] += slope[k] * u + slope[3 + k] * v;
  }
  const Lanes nearness = 1.0 / sqrt(ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2]);
  for (int lane = 0; lane < Lanes::kCount; ++lane) {
    for (int k = 0; k < 3; ++k) rays[lane][k] = ray[k][lane] * nearness[lane];
  }
  return near;
}

/// The last ones overlap with those before, so that all are taken as many at a time as there are lanes.
template <CameraModel M>
RAYBUNDLE_TARGET_CLONES [[gnu::flatten]] bool find_all_rays(const double* parameters,
                                                            std::span<const Eigen::Vector2d> pixels,
                                                            Eigen::Vector3d* rays) {
  Lanes::disagreed = false;
  for (std::size_t i = 0; i < pixels.size(); i += Lanes::kCount) {
    const std::size_t first = std::min(i, pixels.size() - Lanes::kCount);
    if (!find_rays<M>(parameters, &pixels[first], &rays[first])) return false;
  }
  return !Lanes::disagreed;
}

/// Unit rays of pixels; zero where there is none.
template <CameraModel M>
void unproject_all(const double* parameters, std::span<const Eigen::Vector2d> pixels, Eigen::Vector3d* rays) {
  if (pixels.size() >= Lanes::kCount && find_all_rays<M>(parameters, pixels, rays)) {
    double cosine = 1.0;
    for (std::size_t i = 0; i < pixels.size(); ++i) cosine = std::min(cosine, rays[i].z());
    // Beyond the end of the field other rays land on the pixels too, and they are not meant.
    if (cosine >= std::cos(M::max_angle_rad(parameters + 4))) return;
  }
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (unproject<M>(parameters, pixels[i], rays[i])) {
      rays[i].normalize();
    } else {
      rays[i].setZero();
    }
  }
}

/// What a view is seen with.
struct Seen {
  const double* parameters;
  const PointsInView& view;
  Eigen::Matrix3d rotation;
  Eigen::Vector3d translation;
};

/// Corner i, or those of the lanes from there on, in the axes of the camera.
template <typename Number>
[[gnu::always_inline]] inline void place(const Seen& seen, std::size_t i, Number* arm, Number* ray) {
  Number point[3];
  load(&seen.view.points[i], point);
  for (int r = 0; r < 3; ++r) {
    arm[r] = seen.rotation(r, 0) * point[0] + seen.rotation(r, 1) * point[1] + seen.rotation(r, 2) * point[2];
    ray[r] = arm[r] + Number(seen.translation[r]);
  }
}

template <CameraModel M, typename Number>
[[gnu::always_inline]] inline bool squared_distance(const Seen& seen, std::size_t i, double* distance2) {
  const double* parameters = seen.parameters;
  const Shape<M, Number> shape(parameters);
  Number arm[3], ray[3], pixel[2], plane[2];
  place(seen, i, arm, ray);
  load(&seen.view.pixels[i], pixel);
  if (!M::plane_from_ray(shape.values, ray, plane)) return false;
  const Number u = parameters[0] * plane[0] + parameters[2] - pixel[0];
  const Number v = parameters[1] * plane[1] + parameters[3] - pixel[1];
  store(u * u + v * v, distance2);
  return true;
}

template <CameraModel M>
RAYBUNDLE_TARGET_CLONES [[gnu::flatten]] void squared_distances(const Seen& seen, double* distances2) {
  for_each_in_lanes(
      seen.view.points.size(),
      [&]<typename Number>(std::size_t i)
          __attribute__((always_inline)) { return squared_distance<M, Number>(seen, i, distances2 + i); },
      [&](std::size_t i) { distances2[i] = std::numeric_limits<double>::infinity(); });
}

template <CameraModel M, typename Number>
[[gnu::always_inline]] inline bool linearise_at(const Seen& seen, std::size_t i, double scale2, LensRows& rows) {
  constexpr int n = kShapeSize<M>;
  const double* parameters = seen.parameters;
  const Shape<M, Number> shape(parameters);
  Number arm[3], ray[3], pixel[2], plane[2], wrt_ray[6], wrt_shape[n > 0 ? 2 * n : 1], error[2];
  place(seen, i, arm, ray);
  load(&seen.view.pixels[i], pixel);
  if (!M::plane_from_ray(shape.values, ray, plane, wrt_ray, wrt_shape)) return false;
  for (int axis = 0; axis < 2; ++axis)
    error[axis] = parameters[axis] * plane[axis] + parameters[2 + axis] - pixel[axis];
  const Number weight = Number(scale2) / (scale2 + error[0] * error[0] + error[1] * error[1]);
  if (!(weight > Number(kLeastWeight))) return false;
  for (int axis = 0; axis < 2; ++axis) {
    Eigen::MatrixXd& of_axis = rows.of_axis[axis];
    double* column = &of_axis(static_cast<Eigen::Index>(i), 0);
    const auto add = [&](const Number& value) {
      store(value, column);
      column += of_axis.rows();
    };
    add(weight * plane[axis]);
    add(weight);
    const Number focal = weight * parameters[axis];
    for (int k = 0; k < n; ++k) add(focal * wrt_shape[axis * n + k]);
    Number slope[3];
    for (int k = 0; k < 3; ++k) slope[k] = focal * wrt_ray[3 * axis + k];
    add(arm[1] * slope[2] - arm[2] * slope[1]);  // by the rotation: arm × slope
    add(arm[2] * slope[0] - arm[0] * slope[2]);
    add(arm[0] * slope[1] - arm[1] * slope[0]);
    for (int k = 0; k < 3; ++k) add(slope[k]);
    add(weight * error[axis]);
  }
  return true;
}

template <CameraModel M>
RAYBUNDLE_TARGET_CLONES [[gnu::flatten]] void linearise(const Seen& seen, double scale2, LensRows& rows) {
  for_each_in_lanes(
      seen.view.points.size(),
      [&]<typename Number>(std::size_t i)
          __attribute__((always_inline)) { return linearise_at<M, Number>(seen, i, scale2, rows); },
      [&](std::size_t i) {
        for (Eigen::MatrixXd& of_axis : rows.of_axis) of_axis.row(static_cast<Eigen::Index>(i)).setZero();
      });
}

template <CameraModel M>
LensFunctions functions_of() {
  static_assert(kParameterCount<M> <= kMaxLensParameters);
  LensFunctions functions;
  functions.parameters = kParameterCount<M>;
  functions.project = project<M>;
  functions.project_with_jacobians = project_with_jacobians<M>;
  functions.unproject = unproject<M>;
  functions.unproject_all = unproject_all<M>;
  functions.squared_distances = [](const double* parameters, const PointsInView& view, const Rigid3& pose,
                                   std::vector<double>& distances2) {
    distances2.resize(view.points.size());
    squared_distances<M>({parameters, view, pose.rotation.toRotationMatrix(), pose.translation}, distances2.data());
    for (double& distance2 : distances2) {
      if (!std::isfinite(distance2)) distance2 = std::numeric_limits<double>::infinity();
    }
  };
  functions.linearise = [](const double* parameters, const PointsInView& view, const Rigid3& pose, double scale_px,
                           LensRows& rows) {
    const auto corners = static_cast<Eigen::Index>(view.points.size());
    const Eigen::Index padded = padded_for_gram(corners);
    for (Eigen::MatrixXd& of_axis : rows.of_axis) {
      of_axis.resize(padded, kParameterCount<M> + 5);
      of_axis.bottomRows(padded - corners).setZero();
    }
    linearise<M>({parameters, view, pose.rotation.toRotationMatrix(), pose.translation}, scale_px * scale_px, rows);
  };
  return functions;
}

}  // namespace

LensFunctions lens_functions(ModelId model) {
  return with_model(model, []<CameraModel M>() { return functions_of<M>(); });
}

const LensFunctions& start_lens_functions() {
  static const LensFunctions functions = functions_of<StartLens>();
  return functions;
}

}  // namespace raybundle
