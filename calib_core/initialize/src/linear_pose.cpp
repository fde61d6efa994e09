// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "linear_pose.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "raybundle/geometry/rotation.hpp"

namespace raybundle {
namespace {

/// Pose for a rotation: the translation that brings the points nearest to their rays, linear.
std::optional<Rigid3> with_best_translation(const Eigen::Matrix3d& rotation, std::span<const Eigen::Vector3d> points,
                                            std::span<const Eigen::Vector3d> rays, const PrincipalFrame& frame) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d arm = rotation * (points[i] - frame.centre);
    normal += Eigen::Matrix3d::Identity() - rays[i] * rays[i].transpose();
    right -= arm - rays[i] * rays[i].dot(arm);
  }
  const Eigen::Vector3d centre = normal.ldlt().solve(right);
  if (!centre.allFinite()) return std::nullopt;
  return Rigid3{Eigen::Quaterniond(rotation), centre - rotation * frame.centre};
}

/// Eigenvector of the smallest eigenvalue of a positive matrix by inverse iteration: where two are alike, some vector
/// between theirs, which is as good a start as either.
template <typename Matrix>
Eigen::Matrix<double, Matrix::RowsAtCompileTime, 1> smallest_eigenvector(Matrix matrix) {
  constexpr int kIterations = 3;
  matrix.diagonal().array() += 1e-10 * matrix.trace();
  const Eigen::LLT<Matrix> factor(matrix);
  Eigen::Matrix<double, Matrix::RowsAtCompileTime, 1> vector;
  for (int i = 0; i < vector.size(); ++i) vector[i] = 1.0 + 0.1 * i;  // orthogonal to no pose in particular
  for (int iteration = 0; iteration < kIterations; ++iteration) vector = factor.solve(vector).normalized();
  return vector;
}

/// Sum over the pairs of b bᵀ ⊗ (I - r rᵀ), whose smallest eigenvector holds the columns of the projection.
template <int columns>
Eigen::Matrix<double, 3, columns> smallest_projection(std::span<const Eigen::Vector3d> points,
                                                      std::span<const Eigen::Vector3d> rays,
                                                      const PrincipalFrame& frame) {
  using Matrix = Eigen::Matrix<double, 3 * columns, 3 * columns>;
  Matrix normal = Matrix::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d local = frame.local(points[i]);
    Eigen::Matrix<double, columns, 1> b;
    b.template head<columns - 1>() = local.head<columns - 1>();
    b[columns - 1] = 1.0;
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - rays[i] * rays[i].transpose();
    for (int k = 0; k < columns; ++k) {
      for (int l = k; l < columns; ++l) normal.template block<3, 3>(3 * k, 3 * l) += b[k] * b[l] * across;
    }
  }
  normal.template triangularView<Eigen::StrictlyLower>() = normal.transpose();
  const Eigen::Matrix<double, 3 * columns, 1> smallest = smallest_eigenvector(normal);
  Eigen::Matrix<double, 3, columns> projection = Eigen::Map<const Eigen::Matrix<double, 3, columns>>(smallest.data());
  double facing = 0.0;  // the sign that puts the points in front of their rays
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d x = projection.template leftCols<columns - 1>() * frame.local(points[i]).head(columns - 1) +
                              projection.col(columns - 1);
    facing += x.dot(rays[i]) / std::max(x.norm(), 1e-300);
  }
  return facing < 0 ? Eigen::Matrix<double, 3, columns>(-projection) : projection;
}

/// Real roots of a quartic in descending powers, by the companion matrix; none where it is no quartic.
std::vector<double> real_roots(const Eigen::Matrix<double, 5, 1>& coefficients) {
  const double largest = coefficients.cwiseAbs().maxCoeff();
  if (!(std::abs(coefficients[0]) > 1e-12 * largest)) return {};
  Eigen::Matrix4d companion = Eigen::Matrix4d::Zero();
  companion.row(0) = -coefficients.tail<4>().transpose() / coefficients[0];
  companion(1, 0) = companion(2, 1) = companion(3, 2) = 1.0;
  const Eigen::EigenSolver<Eigen::Matrix4d> solver(companion, false);
  std::vector<double> roots;
  for (int i = 0; i < 4; ++i) {
    const std::complex<double> root = solver.eigenvalues()[i];
    if (std::abs(root.imag()) < 1e-4 * std::max(1.0, std::abs(root.real()))) roots.push_back(root.real());
  }
  return roots;
}

/// Right-handed orthonormal axes of a triangle.
Eigen::Matrix3d triangle_axes(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  Eigen::Matrix3d axes;
  axes.col(0) = (b - a).normalized();
  axes.col(2) = (b - a).cross(c - a).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

struct PlaneAxes {
  Eigen::Matrix2d local_from_plane;  ///< rotation
  Eigen::Vector2d spread;            ///< largest first
};

/// Eigenvectors and roots of the eigenvalues of a scatter matrix, in closed form.
PlaneAxes principal_axes(const Eigen::Matrix2d& scatter) {
  const double mean = 0.5 * scatter.trace(), difference = 0.5 * (scatter(0, 0) - scatter(1, 1));
  const double radius = std::hypot(difference, scatter(0, 1));
  const double angle = 0.5 * std::atan2(scatter(0, 1), difference);
  const double largest = mean + radius;
  const double smallest = largest > 0 ? scatter.determinant() / largest : 0.0;
  PlaneAxes axes;
  axes.local_from_plane << std::cos(angle), std::sin(angle), -std::sin(angle), std::cos(angle);
  axes.spread << std::sqrt(std::max(largest, 0.0)), std::sqrt(std::max(smallest, 0.0));
  return axes;
}

}  // namespace

PrincipalFrame principal_frame(std::span<const Eigen::Vector3d> points_in_target) {
  if (points_in_target.empty()) return {};
  // Sums about the first point: near enough to the centre to lose nothing, and all points are read once only.
  double sum[3] = {}, xx = 0.0, xy = 0.0, xz = 0.0, yy = 0.0, yz = 0.0, zz = 0.0;
  for (const Eigen::Vector3d& point : points_in_target) {
    const double x = point[0] - points_in_target[0][0];
    const double y = point[1] - points_in_target[0][1];
    const double z = point[2] - points_in_target[0][2];
    sum[0] += x, sum[1] += y, sum[2] += z;
    xx += x * x, xy += x * y, xz += x * z, yy += y * y, yz += y * z, zz += z * z;
  }
  const double count = static_cast<double>(points_in_target.size());
  const Eigen::Vector3d mean = Eigen::Vector3d(sum[0], sum[1], sum[2]) / count;
  PrincipalFrame frame;
  frame.centre = points_in_target[0] + mean;
  Eigen::Matrix3d scatter;
  scatter << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  scatter -= count * mean * mean.transpose();
  if (scatter.col(2).isZero(0.0)) {  // a board that lies in its own xy plane
    const PlaneAxes axes = principal_axes(scatter.topLeftCorner<2, 2>() / count);
    frame.local_from_target.topLeftCorner<2, 2>() = axes.local_from_plane;
    frame.spread.head<2>() = axes.spread;
    return frame;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter / count);
  frame.local_from_target = solver.eigenvectors().rowwise().reverse().transpose();
  if (frame.local_from_target.determinant() < 0) frame.local_from_target.row(2) *= -1.0;
  frame.spread = solver.eigenvalues().reverse().cwiseMax(0.0).cwiseSqrt();
  return frame;
}

std::optional<Rigid3> linear_planar_pose(std::span<const Eigen::Vector3d> points_in_target,
                                         std::span<const Eigen::Vector3d> rays_in_camera, const PrincipalFrame& frame) {
  const Eigen::Matrix3d h = smallest_projection<3>(points_in_target, rays_in_camera, frame);
  const double scale = 0.5 * (h.col(0).norm() + h.col(1).norm());
  if (!(scale > 1e-12)) return std::nullopt;
  Eigen::Matrix3d axes;
  axes.leftCols<2>() = h.leftCols<2>() / scale;
  axes.col(2) = axes.col(0).cross(axes.col(1));
  const Eigen::Matrix3d rotation = nearest_rotation(axes) * frame.local_from_target;
  return with_best_translation(rotation, points_in_target, rays_in_camera, frame);
}

std::optional<Rigid3> linear_spatial_pose(std::span<const Eigen::Vector3d> points_in_target,
                                          std::span<const Eigen::Vector3d> rays_in_camera,
                                          const PrincipalFrame& frame) {
  const Eigen::Matrix<double, 3, 4> p = smallest_projection<4>(points_in_target, rays_in_camera, frame);
  const Eigen::Matrix3d rotation = nearest_rotation(p.leftCols<3>()) * frame.local_from_target;
  return with_best_translation(rotation, points_in_target, rays_in_camera, frame);
}

Rigid3 mirrored_pose(const Rigid3& camera_from_target, const PrincipalFrame& frame) {
  const Eigen::Vector3d centre = camera_from_target * frame.centre;
  const Eigen::Vector3d sight = centre.normalized();
  const Eigen::Matrix3d mirror = Eigen::Matrix3d::Identity() - 2.0 * sight * sight.transpose();
  // Mirrored at the plane of the target as well, the map is a rotation again and the same for points of the plane.
  const Eigen::Vector3d normal = frame.local_from_target.row(2).transpose();
  const Eigen::Matrix3d flip = Eigen::Matrix3d::Identity() - 2.0 * normal * normal.transpose();
  const Eigen::Matrix3d rotation = mirror * camera_from_target.rotation.toRotationMatrix() * flip;
  return {Eigen::Quaterniond(rotation).normalized(), centre - rotation * frame.centre};
}

std::vector<Rigid3> three_point_poses(const Eigen::Vector3d* points_in_target, const Eigen::Vector3d* rays_in_camera) {
  const Eigen::Vector3d* p = points_in_target;
  const Eigen::Vector3d* j = rays_in_camera;
  const double a2 = (p[1] - p[2]).squaredNorm();
  const double b2 = (p[0] - p[2]).squaredNorm();
  const double c2 = (p[0] - p[1]).squaredNorm();
  if (!((p[1] - p[0]).cross(p[2] - p[0]).norm() > 1e-9 * std::max({a2, b2, c2}))) return {};
  const double cos_a = j[1].dot(j[2]);
  const double cos_b = j[0].dot(j[2]);
  const double cos_c = j[0].dot(j[1]);
  const double q = (a2 - c2) / b2;
  const double s = (a2 + c2) / b2;
  Eigen::Matrix<double, 5, 1> quartic;
  quartic[0] = (q - 1) * (q - 1) - 4 * c2 / b2 * cos_a * cos_a;
  quartic[1] = 4 * (q * (1 - q) * cos_b - (1 - s) * cos_a * cos_c + 2 * c2 / b2 * cos_a * cos_a * cos_b);
  quartic[2] = 2 * (q * q - 1 + 2 * q * q * cos_b * cos_b + 2 * (b2 - c2) / b2 * cos_a * cos_a -
                    4 * s * cos_a * cos_b * cos_c + 2 * (b2 - a2) / b2 * cos_c * cos_c);
  quartic[3] = 4 * (-q * (1 + q) * cos_b + 2 * a2 / b2 * cos_c * cos_c * cos_b - (1 - s) * cos_a * cos_c);
  quartic[4] = (1 + q) * (1 + q) - 4 * a2 / b2 * cos_c * cos_c;

  std::vector<Rigid3> poses;
  const Eigen::Matrix3d target_axes = triangle_axes(p[0], p[1], p[2]);
  for (const double v : real_roots(quartic)) {
    const double divisor = 2 * (cos_c - v * cos_a);
    const double u = ((q - 1) * v * v - 2 * q * cos_b * v + 1 + q) / divisor;
    const double first2 = b2 / (1 + v * v - 2 * v * cos_b);
    if (!(v > 0) || !(u > 0) || !std::isfinite(u) || !(first2 > 0)) continue;
    const double first = std::sqrt(first2);
    const Eigen::Vector3d x0 = first * j[0];
    const Eigen::Matrix3d rotation = triangle_axes(x0, first * u * j[1], first * v * j[2]) * target_axes.transpose();
    if (!rotation.allFinite()) continue;
    poses.push_back({Eigen::Quaterniond(rotation).normalized(), x0 - rotation * p[0]});
  }
  return poses;
}

}  // namespace raybundle
