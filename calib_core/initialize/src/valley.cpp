// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "lens_bundle.hpp"
#include "model_fit.hpp"
#include "raybundle/geometry/gram.hpp"
#include "raybundle/geometry/rotation.hpp"
#include "raybundle/initialize/other_optima.hpp"

namespace raybundle {
namespace {

constexpr std::size_t kSamples = 60;   ///< rays that the projections are compared on
constexpr int kMostSteps = 16;         ///< along the valley to either side
constexpr int kCorrections = 6;        ///< Gauss-Newton steps back to the valley's floor
constexpr double kFirstStep_px = 0.5;  ///< of the first step: what the parameters would do one by one
constexpr double kFarOut = 1e5;        ///< a parameter of the lens's shape: beyond only its neighbours cancel it
constexpr double kBent = 1.5;          ///< times what is predicted, or the other way round
constexpr double kGrowth = 1.7;        ///< of the steps

/// A lens, turned; a turn of the lens is a turn of all boards.
struct Place {
  LensVector lens;
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
};

/// How a place's projections differ from those looked for, with the normal equations of lens and turn.
struct Difference {
  double rms_px = 0.0;
  Eigen::MatrixXd normal;  ///< lens, then turn
  Eigen::VectorXd right;
};

std::optional<Difference> difference(const LensFunctions& lens, const PointsInView& field, const Place& place) {
  thread_local Eigen::MatrixXd rows, products;  // by lens, turn and error
  const int n = lens.parameters;
  const auto values = static_cast<Eigen::Index>(2 * field.points.size());
  rows.setZero(padded_for_gram(values), n + 4);
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> wrt_ray;
  double wrt_parameters[2 * kMaxLensParameters];
  for (std::size_t i = 0; i < field.points.size(); ++i) {
    const Eigen::Vector3d ray = place.turn * field.points[i];
    if (!lens.project_with_jacobians(place.lens.data(), ray, pixel, wrt_ray, wrt_parameters)) return std::nullopt;
    const Eigen::Matrix<double, 2, 3> wrt_turn = -wrt_ray * skew(ray);
    for (int axis = 0; axis < 2; ++axis) {
      auto row = rows.row(static_cast<Eigen::Index>(2 * i) + axis);
      for (int k = 0; k < n; ++k) row[k] = wrt_parameters[axis * n + k];
      for (int k = 0; k < 3; ++k) row[n + k] = wrt_turn(axis, k);
      row[n + 3] = pixel[axis] - field.pixels[i][axis];
    }
  }
  gram(rows, products);
  Difference found;
  found.normal = products.topLeftCorner(n + 3, n + 3).selfadjointView<Eigen::Upper>();
  found.right = -products.col(n + 3).head(n + 3);
  found.rms_px = std::sqrt(products(n + 3, n + 3) / static_cast<double>(field.points.size()));
  return std::isfinite(found.rms_px) ? std::optional(found) : std::nullopt;
}

/// The normal equations of the lens when the turn makes good what it can.
Eigen::MatrixXd turn_eliminated(const Difference& here, int n) {
  const Eigen::MatrixXd turn = here.normal.bottomRightCorner<3, 3>();
  const Eigen::MatrixXd cross = here.normal.topRightCorner(n, 3);
  return here.normal.topLeftCorner(n, n) - cross * turn.ldlt().solve(cross.transpose());
}

/// The direction of the lens that moves the pixels least when the turn makes good what it can, every parameter in units
/// of what it alone does to them. Of length such that those effects make `kFirstStep_px` together.
LensVector weakest_direction(const Difference& here, int n, std::size_t samples) {
  const Eigen::MatrixXd reduced = turn_eliminated(here, n);
  const Eigen::VectorXd scale = here.normal.diagonal().head(n).cwiseMax(1e-30).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * reduced * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
  return kFirstStep_px * std::sqrt(2.0 * static_cast<double>(samples)) *
         scale.cwiseProduct(eigen.eigenvectors().col(0));
}

/// Back to the floor of the valley across the direction of the last step.
std::optional<Difference> correct(const LensFunctions& lens, const PointsInView& field, const LensVector& direction,
                                  Place& place) {
  const int n = lens.parameters;
  auto here = difference(lens, field, place);
  for (int iteration = 0; here && iteration < kCorrections; ++iteration) {
    const Eigen::VectorXd scale = here->normal.diagonal().cwiseMax(1e-30).cwiseSqrt().cwiseInverse();
    Eigen::MatrixXd scaled = scale.asDiagonal() * here->normal * scale.asDiagonal();
    // Along the direction nothing moves; elsewhere a little damping.
    Eigen::VectorXd along = Eigen::VectorXd::Zero(n + 3);
    along.head(n) = direction.cwiseQuotient(scale.head(n));
    along.normalize();
    scaled += 1e3 * along * along.transpose();
    scaled.diagonal().array() += 1e-10;
    const Eigen::VectorXd step = scale.cwiseProduct(scaled.ldlt().solve(scale.cwiseProduct(here->right)));
    if (!step.allFinite()) return std::nullopt;
    Place moved = place;
    moved.lens += step.head(n);
    moved.turn = rotation_from_vector(step.tail<3>()) * place.turn;
    const auto there = difference(lens, field, moved);
    if (!there || !(there->rms_px < here->rms_px)) break;
    const bool settled = there->rms_px > 0.99 * here->rms_px;
    place = moved;
    here = there;
    if (settled) break;
  }
  return here;
}

/// The way along the floor to one side, as far as the projections stay alike.
std::vector<LensVector> way_along(const LensFunctions& lens, const PointsInView& field, const LensVector& start,
                                  double side, double alike_px) {
  std::vector<LensVector> way;
  Place place{start};
  auto here = difference(lens, field, place);
  LensVector last;
  double stride = 1.0;
  for (int k = 0; here && k < kMostSteps; ++k) {
    LensVector direction = side * weakest_direction(*here, lens.parameters, field.points.size());
    if (last.size() > 0) {
      const LensVector units = here->normal.diagonal().head(lens.parameters).cwiseMax(1e-30);
      if (direction.cwiseProduct(units).dot(last) < 0) direction = -direction;
    }
    Place next = place;
    next.lens += stride * direction;
    const auto there = correct(lens, field, direction, next);
    if (!there || !(there->rms_px <= alike_px) || !(next.lens[0] > 0) || !(next.lens[1] > 0) ||
        next.lens.tail(lens.parameters - 4).lpNorm<Eigen::Infinity>() > kFarOut) {
      stride *= 0.25;
      if (stride < 0.1) break;
      continue;
    }
    place = next;
    here = there;
    last = direction;
    stride *= kGrowth;
    way.push_back(place.lens);
  }
  return way;
}

/// Whether the valley may have another optimum: it has no end in sight, or bends, so that the linear prediction of how
/// far its end is apart fails. Where neither is so the lens is known well enough for one optimum.
bool open_or_bent(const LensFunctions& lens, const PointsInView& field, const LensVector& start,
                  const std::vector<LensVector>& way) {
  if (static_cast<int>(way.size()) >= kMostSteps - 2) return true;
  const auto here = difference(lens, field, {start});
  Place end{way.back()};
  const auto there = correct(lens, field, way.back() - start, end);
  if (!here || !there) return true;
  const LensVector step = end.lens - start;
  const Eigen::MatrixXd normal = turn_eliminated(*here, lens.parameters);
  const double predicted_px =
      std::sqrt(std::max(0.0, step.dot(normal * step)) / static_cast<double>(field.points.size()));
  return predicted_px > kBent * there->rms_px || there->rms_px > kBent * predicted_px;
}

}  // namespace

std::vector<Camera> cameras_along_valley(const Camera& camera, const std::vector<Eigen::Vector3d>& rays_in_camera,
                                         double alike_px, std::size_t of_each_side) {
  const LensFunctions lens = lens_functions(camera.model);
  const PointsInView field = field_seen(camera, rays_in_camera, kSamples);
  std::vector<Camera> cameras;
  if (field.points.empty()) return cameras;
  for (const double side : {1.0, -1.0}) {
    const std::vector<LensVector> way = way_along(lens, field, camera.parameters, side, alike_px);
    if (way.empty() || !open_or_bent(lens, field, camera.parameters, way)) continue;
    const std::size_t count = std::min(of_each_side, way.size());
    for (std::size_t k = way.size() - count; k < way.size(); ++k) {
      cameras.push_back({camera.model, camera.size, way[k]});
    }
  }
  return cameras;
}

}  // namespace raybundle
