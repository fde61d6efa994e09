// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "raybundle/camera/camera.hpp"
#include "raybundle/geometry/rigid3.hpp"

namespace raybundle {

/// Board points and where one view has them, aligned.
struct PointsInView {
  std::vector<Eigen::Vector3d> points;  ///< in the target [m]
  std::vector<Eigen::Vector2d> pixels;  ///< [px]
};

constexpr int kMaxLensParameters = 24;
using LensMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxLensParameters, kMaxLensParameters>;
using LensVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxLensParameters, 1>;

/// Rows of a view's corners, of u and of v: by focal length, principal point, shape (n - 4), turn (3) and shift (3) of
/// the pose, and the error, each times the root of ρ' of the Geman-McClure loss; zero where the lens does not project a
/// corner, where one is too far off to count, and up to a multiple of four.
struct LensRows {
  Eigen::MatrixXd of_axis[2];

  /// Where the parameter of a column is among fx fy cx cy and the shape, with pose and error behind.
  static int index(int axis, int column) { return column < 2 ? 2 * column + axis : column + 2; }
};

/// A camera model without its type: fx fy cx cy, then the shape.
struct LensFunctions {
  int parameters = 0;
  bool (*project)(const double* parameters, const Eigen::Vector3d& ray, Eigen::Vector2d& pixel) = nullptr;
  /// wrt_parameters: 2×n row-major
  bool (*project_with_jacobians)(const double* parameters, const Eigen::Vector3d& ray, Eigen::Vector2d& pixel,
                                 Eigen::Matrix<double, 2, 3, Eigen::RowMajor>& wrt_ray,
                                 double* wrt_parameters) = nullptr;
  bool (*unproject)(const double* parameters, const Eigen::Vector2d& pixel, Eigen::Vector3d& ray) = nullptr;
  /// Unit rays of as many pixels; zero where there is none.
  void (*unproject_all)(const double* parameters, std::span<const Eigen::Vector2d> pixels,
                        Eigen::Vector3d* rays) = nullptr;
  /// Squared distances [px²] of a view's corners from where the lens puts them; infinite where it does not project
  /// them.
  void (*squared_distances)(const double* parameters, const PointsInView& view, const Rigid3& pose,
                            std::vector<double>& distances2) = nullptr;
  /// What a view's corners say of lens and pose, as LensRows.
  void (*linearise)(const double* parameters, const PointsInView& view, const Rigid3& pose, double scale_px,
                    LensRows& rows) = nullptr;
};

/// The functions of a model of the list, and of StartLens.
LensFunctions lens_functions(ModelId model);
const LensFunctions& start_lens_functions();

}  // namespace raybundle
