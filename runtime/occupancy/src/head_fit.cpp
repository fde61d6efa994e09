// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "head_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace raybundle {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr int kIterations = 14, kWideIterations = 6;
constexpr double kCut = 3.0;      // sigmas, of the biweight; at first thrice as wide
constexpr double kGrazing = 0.3;  // cosine: what is seen more flatly beside the outline is the matcher's smear
constexpr double kMostSize = 0.5, kMostTurn_rad = 0.3, kMostGrowth = 0.1;  // of the logarithm; of a step

struct Ellipsoid {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double log_size = 0.0, turn_rad = 0.0, nod_rad = 0.0;

  Eigen::Vector3d semi_axes_m(const HeadOptions& options) const {
    return options.semi_axes_m.array() * (log_size * options.growth).array().exp();
  }

  Eigen::Matrix3d vehicle_from_head() const {
    const Eigen::AngleAxisd turn(turn_rad, Eigen::Vector3d::UnitZ()), nod(nod_rad, Eigen::Vector3d::UnitY());
    return (turn * nod).toRotationMatrix();
  }
};

// How far a place is from the surface, to first order, and how that changes with centre, size, turn and nod.
struct Distance {
  double m = 0.0;
  Vector6 row = Vector6::Zero();
};

// The sums of one step.
class Sums {
 public:
  Sums(const Ellipsoid& ellipsoid, const Eigen::Vector3d& eye, double alike_points, const HeadOptions& options)
      : options_(options),
        alike_points_(alike_points),
        eye_(eye),
        turn_(ellipsoid.vehicle_from_head()),
        axes_(ellipsoid.semi_axes_m(options)),
        centre_(ellipsoid.centre),
        eye_in_ball_(in_ball(eye_)) {}

  void add(const ScenePoint& point, double sigma_m, double cut) {
    const Eigen::Vector3d place = in_ball(point.x_in_vehicle), through = place - eye_in_ball_;
    const double nearest = -eye_in_ball_.dot(through) / through.squaredNorm();  // share of the range
    const Eigen::Vector3d past = eye_in_ball_ + nearest * through;
    const double outline = past.norm();
    if (nearest <= 0.0 || outline > 2.0) return;
    const double range = (point.x_in_vehicle - eye_).norm();
    const bool passes = (1.0 - nearest) * range > kBehind_m;
    const double rho = passes ? outline : place.norm();
    if (rho > 2.0 || rho < 0.3 || (passes ? past : place).z() < kChin || (passes && rho > 1.0)) return;

    const Distance distance = distance_of(passes ? past : place);
    const double facing = (point.x_in_vehicle - eye_).dot(distance.row.head<3>()) / range;
    if (facing < (outline > 1.0 ? -kGrazing : 0.0)) return;  // its far side
    const double depth_m = passes ? 0.0 : options_.curved_sigmas * sigma_m * facing;
    const double variance = depth_m * depth_m + options_.shape_sigma_m * options_.shape_sigma_m;
    const double share2 = distance.m * distance.m / (cut * cut * variance);
    if (share2 >= 1.0) return;
    const double weight = (1.0 - share2) * (1.0 - share2) / variance;
    information += weight / alike_points_ * distance.row * distance.row.transpose();
    gradient += weight / alike_points_ * distance.m * distance.row;
    if (passes) return;
    squares_in_sigmas_ += distance.m * distance.m / variance;
    ++points;
  }

  void add_prior(int i, double value, double sigma) {
    information(i, i) += 1.0 / (sigma * sigma);
    gradient[i] += value / (sigma * sigma);
  }

  // From the eye towards a place in the ellipsoid: where it begins, and how that changes with what is fitted.
  struct Front {
    Eigen::Vector3d place;
    Eigen::Matrix<double, 3, 6> rows;
  };

  Front front(const Eigen::Vector3d& inner) const {
    const double range = (inner - eye_).norm();
    const Eigen::Vector3d ray = (inner - eye_) / range, along = in_ball(inner) - eye_in_ball_;
    const double half = eye_in_ball_.dot(along), square = along.squaredNorm();
    const double inside = std::max(0.0, half * half - square * (eye_in_ball_.squaredNorm() - 1.0));
    const double share = (-half - std::sqrt(inside)) / square;
    const Eigen::Vector3d place = eye_ + share * range * ray;
    const Distance distance = distance_of(in_ball(place));
    const Eigen::RowVector3d normal = -distance.row.head<3>();
    Front front{place, Eigen::Matrix<double, 3, 6>::Zero()};
    front.rows.leftCols<3>() = share * (Eigen::Matrix3d::Identity() - ray * ray.transpose());
    const Eigen::Matrix<double, 1, 6> off = distance.row.transpose() + normal * front.rows;
    front.rows -= ray * off / normal.dot(ray);
    return front;
  }

  double misfit() const { return std::sqrt(squares_in_sigmas_ / std::max(1, points)); }

  Matrix6 information = Matrix6::Zero();
  Vector6 gradient = Vector6::Zero();
  int points = 0;

 private:
  Eigen::Vector3d in_ball(const Eigen::Vector3d& x) const {
    return (turn_.transpose() * (x - centre_)).cwiseQuotient(axes_);
  }

  Distance distance_of(const Eigen::Vector3d& place) const {
    const double rho = place.norm();
    Eigen::Vector3d normal = turn_ * place.cwiseQuotient(axes_) / rho;
    const double slope = normal.norm();
    normal /= slope;
    const Eigen::Vector3d off = turn_ * place.cwiseProduct(axes_);
    Distance distance{(rho - 1.0) / slope, {}};
    const Eigen::Vector3d grown = turn_ * place.cwiseProduct(axes_).cwiseProduct(options_.growth);
    distance.row << -normal, -normal.dot(grown) / rho, -normal.dot(Eigen::Vector3d::UnitZ().cross(off)),
        -normal.dot(turn_.col(1).cross(off));
    return distance;
  }

  const HeadOptions& options_;
  double alike_points_;
  Eigen::Vector3d eye_;
  Eigen::Matrix3d turn_;
  Eigen::Vector3d axes_, centre_, eye_in_ball_;
  double squares_in_sigmas_ = 0.0;
};

// The logarithm of the size that heads so far from the bight commonly have: leaning, they hardly come nearer to it.
double common_log_size(const SeatPose& seat, const Eigen::Vector3d& centre, const HeadOptions& options) {
  const double from_bight_m = (Eigen::Vector2d(centre.x(), centre.z()) - seat.bight).norm();
  return std::clamp(options.shrink_per_m * (from_bight_m - options.small_below_m), options.least_log_size, 0.0);
}

}  // namespace

Head fit_head(const CappedScan& capped, const SeatPose& seat, const Eigen::Vector3d& start,
              const HeadOptions& options) {
  const Eigen::Vector3d& eye = capped.scan().viewpoint_in_vehicle;
  Head head;
  Ellipsoid ellipsoid{.centre = start, .nod_rad = options.nod_rad};
  Matrix6 covariance = Matrix6::Zero();
  const double radius_m = options.semi_axes_m.mean();
  const double patches = M_PI * radius_m * radius_m / (options.alike_m * options.alike_m);
  double alike_points = options.least_points / patches;
  for (int i = 0; i < kIterations; ++i) {
    Sums sums(ellipsoid, eye, alike_points, options);
    const double cut = kCut * (1.0 + 2.0 * std::max(0.0, 1.0 - static_cast<double>(i) / kWideIterations));
    for (const ScenePoint& point : capped.scan().points) sums.add(point, capped.sigma_m(point), cut);
    if (sums.points < options.least_points) return head;
    alike_points = std::max(1.0, sums.points / patches);
    sums.add_prior(3, ellipsoid.log_size - common_log_size(seat, ellipsoid.centre, options), options.size_sigma);
    sums.add_prior(4, ellipsoid.turn_rad, options.turn_sigma_rad);
    sums.add_prior(5, ellipsoid.nod_rad - options.nod_rad, options.nod_sigma_rad);
    const Vector6 step = -sums.information.ldlt().solve(sums.gradient);
    ellipsoid.centre += step.head<3>();
    ellipsoid.log_size =
        std::clamp(ellipsoid.log_size + std::clamp(step[3], -kMostGrowth, kMostGrowth), -kMostSize, kMostSize);
    ellipsoid.turn_rad += std::clamp(step[4], -kMostTurn_rad, kMostTurn_rad);
    ellipsoid.nod_rad += std::clamp(step[5], -kMostTurn_rad, kMostTurn_rad);
    head.points = sums.points;
    head.misfit = sums.misfit();
    covariance = sums.information.inverse();
  }
  head.vehicle_from_head = ellipsoid.vehicle_from_head();
  head.centre = ellipsoid.centre + head.vehicle_from_head * options.centre_from_hair_m;
  const Sums::Front front = Sums(ellipsoid, eye, alike_points, options).front(head.centre);
  head.front = front.place;
  head.front_covariance_m2 = front.rows * covariance * front.rows.transpose();
  head.front_covariance_m2.diagonal().array() += options.shape_sigma_m * options.shape_sigma_m;
  head.covariance_m2 = covariance.topLeftCorner<3, 3>();
  head.covariance_m2.diagonal().array() += options.hair_sigma_m * options.hair_sigma_m;
  head.found = ellipsoid.centre.allFinite();
  head.semi_axes_m = ellipsoid.semi_axes_m(options);
  head.size = std::exp(ellipsoid.log_size);
  return head;
}

}  // namespace raybundle
