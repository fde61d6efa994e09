// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "linear_pose.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <type_traits>

#include "raybundle/camera/lanes.hpp"
#include "raybundle/geometry/rotation.hpp"
#include "raybundle/geometry/target_clones.hpp"
#include "small_cholesky.hpp"

namespace raybundle {
namespace {

/// Entries of a symmetric 3×3 matrix, row by row.
constexpr int kSymmetric = 6;

Eigen::Matrix3d symmetric(const double* upper) {
  Eigen::Matrix3d matrix;
  matrix << upper[0], upper[1], upper[2], upper[1], upper[3], upper[4], upper[2], upper[4], upper[5];
  return matrix;
}

/// Sums over points, of one number or of lanes of them, about the first point: near enough to the centre to lose
/// nothing, and all points are read once only.
template <typename Number>
struct MomentSums {
  Number sum[3];
  Number squares[kSymmetric];
};

RAYBUNDLE_TARGET_CLONES [[gnu::flatten]] void sum_moments(std::span<const Eigen::Vector3d> points,
                                                          MomentSums<double>& sums) {
  MomentSums<Lanes> of_lanes{};
  const auto add = [&]<typename Number>(std::size_t i, MomentSums<Number> & to) __attribute__((always_inline)) {
    Number x[3];
    load(&points[i], x);
    for (int a = 0; a < 3; ++a) {
      x[a] = x[a] - points[0][a];
      to.sum[a] += x[a];
    }
    for (int a = 0, e = 0; a < 3; ++a) {
      for (int b = a; b < 3; ++b, ++e) to.squares[e] += x[a] * x[b];
    }
  };
  for_each_in_lanes(
      points.size(),
      [&]<typename Number>(std::size_t i) __attribute__((always_inline)) {
        if constexpr (std::is_same_v<Number, Lanes>) {
          add(i, of_lanes);
        } else {
          add(i, sums);
        }
        return true;
      },
      [](std::size_t) {});
  for (int a = 0; a < 3; ++a) sums.sum[a] += of_lanes.sum[a].sum();
  for (int e = 0; e < kSymmetric; ++e) sums.squares[e] += of_lanes.squares[e].sum();
}

/// Where a point is in its principal frame: x, y, 1, z.
constexpr int kPlace = 4;

/// Sums over the pairs of a point at the place b and its ray r, of one number or of lanes of them.
template <typename Number>
struct PairSums {
  Number across[kPlace][kPlace][kSymmetric];  ///< b_k b_l (I - r rᵀ), k ≤ l
  Number along[kPlace][3];                    ///< b_k r
};

template <bool spatial, typename Number>
[[gnu::always_inline]] inline void add_pairs(const Eigen::Vector3d* points, const Eigen::Vector3d* rays,
                                             const PrincipalFrame& frame, const Eigen::Matrix3d& unit_from_target,
                                             PairSums<Number>& sums) {
  Number point[3], r[3], place[3];
  load(points, point);
  load(rays, r);
  for (int k = 0; k < 3; ++k) point[k] = point[k] - Number(frame.centre[k]);
  for (int k = 0; k < 3; ++k) {
    place[k] =
        unit_from_target(k, 0) * point[0] + unit_from_target(k, 1) * point[1] + unit_from_target(k, 2) * point[2];
  }
  const Number b[kPlace] = {place[0], place[1], Number(1.0), place[2]};
  const Number across[kSymmetric] = {Number(1.0) - r[0] * r[0], -(r[0] * r[1]), -(r[0] * r[2]),
                                     Number(1.0) - r[1] * r[1], -(r[1] * r[2]), Number(1.0) - r[2] * r[2]};
  for (int k = 0; k < kPlace; ++k) {
    for (int l = k; l < kPlace; ++l) {
      if (!spatial && l == 3 && k != 2) continue;
      const Number both = b[k] * b[l];
      for (int e = 0; e < kSymmetric; ++e) sums.across[k][l][e] += both * across[e];
    }
    for (int e = 0; e < 3; ++e) sums.along[k][e] += b[k] * r[e];
  }
}

/// All sums; where the points are not `spatial` without those of z times x, y and z.
template <bool spatial>
RAYBUNDLE_TARGET_CLONES [[gnu::flatten]] void sum_pairs(std::span<const Eigen::Vector3d> points,
                                                        std::span<const Eigen::Vector3d> rays,
                                                        const PrincipalFrame& frame, PairSums<double>& sums) {
  const Eigen::Matrix3d unit_from_target = frame.local_from_target / frame.spread[0];
  PairSums<Lanes> of_lanes{};
  for_each_in_lanes(
      points.size(),
      [&]<typename Number>(std::size_t i) __attribute__((always_inline)) {
        if constexpr (std::is_same_v<Number, Lanes>) {
          add_pairs<spatial>(&points[i], &rays[i], frame, unit_from_target, of_lanes);
        } else {
          add_pairs<spatial>(&points[i], &rays[i], frame, unit_from_target, sums);
        }
        return true;
      },
      [](std::size_t) {});
  for (int k = 0; k < kPlace; ++k) {
    for (int l = k; l < kPlace; ++l) {
      for (int e = 0; e < kSymmetric; ++e) sums.across[k][l][e] += of_lanes.across[k][l][e].sum();
    }
    for (int e = 0; e < 3; ++e) sums.along[k][e] += of_lanes.along[k][e].sum();
  }
}

/// Pose for a rotation: the translation that brings the points nearest to their rays, linear.
std::optional<Rigid3> with_best_translation(const Eigen::Matrix3d& camera_from_local, const PairSums<double>& sums,
                                            const PrincipalFrame& frame) {
  const Eigen::Vector3d right = symmetric(sums.across[0][2]) * camera_from_local.col(0) +
                                symmetric(sums.across[1][2]) * camera_from_local.col(1) +
                                symmetric(sums.across[2][3]) * camera_from_local.col(2);
  const Eigen::Vector3d centre = -frame.spread[0] * SmallCholesky<3>(symmetric(sums.across[2][2])).solve(right);
  if (!centre.allFinite()) return std::nullopt;
  const Eigen::Matrix3d rotation = camera_from_local * frame.local_from_target;
  return Rigid3{Eigen::Quaterniond(rotation), centre - rotation * frame.centre};
}

/// Eigenvector of the smallest eigenvalue of a positive matrix by inverse iteration: where two are alike, some vector
/// between theirs, which is as good a start as either.
template <int n>
Eigen::Matrix<double, n, 1> smallest_eigenvector(Eigen::Matrix<double, n, n> matrix) {
  constexpr int kIterations = 3;
  matrix.diagonal().array() += 1e-10 * matrix.trace();
  const SmallCholesky<n> factor(matrix);
  Eigen::Matrix<double, n, 1> vector;
  for (int i = 0; i < n; ++i) vector[i] = 1.0 + 0.1 * i;  // orthogonal to no pose in particular
  for (int iteration = 0; iteration < kIterations; ++iteration) vector = factor.solve(vector).normalized();
  return vector;
}

/// Columns of the projection of the first places b: the smallest eigenvector of the sum of b bᵀ ⊗ (I - r rᵀ).
template <int places>
Eigen::Matrix<double, 3, places> smallest_projection(const PairSums<double>& sums) {
  Eigen::Matrix<double, 3 * places, 3 * places> normal;
  for (int k = 0; k < places; ++k) {
    for (int l = k; l < places; ++l) normal.template block<3, 3>(3 * l, 3 * k) = symmetric(sums.across[k][l]);
  }
  const Eigen::Matrix<double, 3 * places, 1> smallest = smallest_eigenvector<3 * places>(normal);
  Eigen::Matrix<double, 3, places> projection = Eigen::Map<const Eigen::Matrix<double, 3, places>>(smallest.data());
  double facing = 0.0;  // the sign that puts the points in front of their rays
  for (int k = 0; k < places; ++k) facing += projection.col(k).dot(Eigen::Map<const Eigen::Vector3d>(sums.along[k]));
  return facing < 0 ? Eigen::Matrix<double, 3, places>(-projection) : projection;
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
  MomentSums<double> sums{};
  sum_moments(points_in_target, sums);
  const double count = static_cast<double>(points_in_target.size());
  const Eigen::Vector3d mean = Eigen::Map<const Eigen::Vector3d>(sums.sum) / count;
  PrincipalFrame frame;
  frame.centre = points_in_target[0] + mean;
  Eigen::Matrix3d scatter = symmetric(sums.squares);
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
  PairSums<double> sums{};
  sum_pairs<false>(points_in_target, rays_in_camera, frame, sums);
  const Eigen::Matrix3d h = smallest_projection<3>(sums);
  const double scale = 0.5 * (h.col(0).norm() + h.col(1).norm());
  if (!(scale > 1e-12)) return std::nullopt;
  Eigen::Matrix3d axes;
  axes.leftCols<2>() = h.leftCols<2>() / scale;
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return with_best_translation(nearest_rotation(axes), sums, frame);
}

std::optional<Rigid3> linear_spatial_pose(std::span<const Eigen::Vector3d> points_in_target,
                                          std::span<const Eigen::Vector3d> rays_in_camera,
                                          const PrincipalFrame& frame) {
  PairSums<double> sums{};
  sum_pairs<true>(points_in_target, rays_in_camera, frame, sums);
  const Eigen::Matrix<double, 3, 4> p = smallest_projection<4>(sums);
  Eigen::Matrix3d axes;
  axes << p.col(0), p.col(1), p.col(3);
  return with_best_translation(nearest_rotation(axes), sums, frame);
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
