// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/seat_fit.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "capped_scan.hpp"

namespace raybundle {
namespace {

// Where the bight lies from the H-point, and how long the flat parts are that every seat has.
constexpr double kBightBehind_m = 0.12, kBightBelow_m = 0.11, kSlack_m = 0.06,
                 kLiftSlack_m = 0.02;  // less: what lies flat on the cushion lifts its line
constexpr double kLeastPitch_rad = 0.05, kMostPitch_rad = 0.40, kSlack_rad = 0.05;
constexpr double kMoved_m = 0.06, kMoved_rad = 0.12;  // no two fits of one seat are so far apart
constexpr double kShape_m = 0.005;                    // how far a good seat is from two planes
struct Reach {
  double from_m, to_m;
};
constexpr Reach kCushion{0.05, 0.42}, kBack{0.12, 0.56};

// A line in x and z, and what supports it.
struct Line {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  Eigen::Vector2d along = Eigen::Vector2d::UnitX();
  int points = 0;
  double scatter_m2 = 0.0, spread_m2 = 0.0;  // across and along

  Eigen::Vector2d across() const { return {-along.y(), along.x()}; }
};

// Weighted principal axis of the points that lie near the line through `start` along `along`, within `reach` of it.
Line grown(const CappedScan& capped, const Eigen::Vector2d& start, const Eigen::Vector2d& along, const Reach& reach,
           double tolerance_m, double half_width_m) {
  const Eigen::Vector2d across(-along.y(), along.x());
  double weights = 0.0;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  Line line;
  for (const ScenePoint& point : capped.scan().points) {
    if (std::abs(point.x_in_vehicle.y()) > half_width_m) continue;
    const Eigen::Vector2d off(point.x_in_vehicle.x() - start.x(), point.x_in_vehicle.z() - start.y());
    const double at = off.dot(along), distance = off.dot(across);
    const double sigma_m = capped.sigma_m(point);
    const double bound = std::hypot(tolerance_m, 2.0 * sigma_m);
    if (at < reach.from_m || at > reach.to_m || std::abs(distance) > bound) continue;
    const double share = distance / bound, in = 1 - share * share;
    const double weight = in * in / (kShape_m * kShape_m + sigma_m * sigma_m);  // Tukey's biweight
    weights += weight;
    mean += weight * off;
    squares += weight * off * off.transpose();
    ++line.points;
  }
  if (weights <= 0.0) return line;
  mean /= weights;
  const Eigen::Matrix2d scatter = squares / weights - mean * mean.transpose();
  const double angle = 0.5 * std::atan2(2 * scatter(0, 1), scatter(0, 0) - scatter(1, 1));
  line.along = {std::cos(angle), std::sin(angle)};
  if (line.along.dot(along) < 0.0) line.along = -line.along;
  line.centre = start + mean;
  line.scatter_m2 = std::max(0.0, line.across().dot(scatter * line.across()));
  line.spread_m2 = line.along.dot(scatter * line.along);
  return line;
}

bool meet(const Line& cushion, const Line& back, SeatPose& pose) {
  Eigen::Matrix2d axes;
  axes << cushion.along, -back.along;
  const double area = axes.determinant();
  if (std::abs(area) < 0.3) return false;  // nearly parallel
  const Eigen::Vector2d between = back.centre - cushion.centre;
  const double t = (between.x() * axes(1, 1) - between.y() * axes(0, 1)) / area;
  pose.bight = cushion.centre + t * cushion.along;
  pose.cushion_pitch_rad = std::atan2(cushion.along.y(), cushion.along.x());
  pose.recline_rad = std::atan2(-back.along.x(), back.along.y());
  return true;
}

bool allowed(const VehicleLayout& layout, const SeatPose& pose) {
  const bool travel = std::abs(pose.bight.x() + kBightBehind_m) < layout.track_m + kSlack_m &&
                      std::abs(pose.bight.y() + kBightBelow_m) < layout.lift_m + kLiftSlack_m;
  return travel && pose.recline_rad > layout.least_recline_rad - kSlack_rad &&
         pose.recline_rad < layout.most_recline_rad + kSlack_rad && pose.cushion_pitch_rad > kLeastPitch_rad &&
         pose.cushion_pitch_rad < kMostPitch_rad;
}

// From one start; wide at first, then as narrow as the options say.
SeatFit grown_from(SeatPose pose, const VehicleLayout& layout, const CappedScan& scan, const SeatFitOptions& options) {
  SeatFit fit;
  Line cushion, back;
  for (int i = 0; i < options.iterations; ++i) {
    const double tolerance = options.tolerance_m * (1.0 + 2.0 * (options.iterations - 1 - i) / options.iterations);
    cushion = grown(scan, pose.bight, pose.cushion_forward(), kCushion, tolerance, options.half_width_m);
    back = grown(scan, pose.bight, pose.back_up(), kBack, tolerance, options.half_width_m);
    if (cushion.points < options.least_points || back.points < options.least_points) return fit;
    if (!meet(cushion, back, pose) || !allowed(layout, pose)) return fit;
  }
  fit.pose = pose;
  fit.found = true;
  fit.cushion_points = cushion.points;
  fit.back_points = back.points;
  // Of a line: position across at the bight, and angle.
  const auto at_bight = [&](const Line& line) {
    const double away = (line.centre - pose.bight).norm();
    return line.scatter_m2 * options.alike_points / line.points * (1.0 + away * away / line.spread_m2);
  };
  const double cushion_m2 = at_bight(cushion), back_m2 = at_bight(back);
  const Eigen::Vector2d cushion_across = cushion.across(), back_across = back.across();
  const double sine = cushion_across.x() * back_across.y() - cushion_across.y() * back_across.x();
  fit.bight_sigma_m =
      (cushion_m2 * back_across.cwiseAbs2() + back_m2 * cushion_across.cwiseAbs2()).cwiseSqrt().reverse() /
      std::abs(sine);
  fit.recline_sigma_rad = std::sqrt(back.scatter_m2 * options.alike_points / (back.points * back.spread_m2));
  return fit;
}

// Of the points beside which the seat's flat middle lies, those that are clear of it.
double hidden_share(const SeatPose& pose, const CappedScan& capped, const SeatFitOptions& options) {
  int on_it = 0, all = 0;
  for (const ScenePoint& point : capped.scan().points) {
    if (std::abs(point.x_in_vehicle.y()) > options.half_width_m) continue;
    const Eigen::Vector2d off(point.x_in_vehicle.x() - pose.bight.x(), point.x_in_vehicle.z() - pose.bight.y());
    const double along = off.dot(pose.cushion_forward()), up = off.dot(pose.back_up());
    if (along > kCushion.to_m || up > kBack.to_m) continue;
    ++all;
    on_it += std::min(pose.above_cushion(point.x_in_vehicle), pose.before_back(point.x_in_vehicle)) >
             options.occupied_m + 2.0 * capped.sigma_m(point);
  }
  return all == 0 ? 0.0 : static_cast<double>(on_it) / all;
}

}  // namespace

SeatFit fit_seat(const VehicleLayout& layout, const Scan& scan, const SeatFitOptions& options) {
  const CappedScan capped(scan);
  SeatFit best;
  for (int i = -2; i <= 2; ++i) {
    for (int j = 0; j < 4; ++j) {
      SeatPose start;
      start.bight = {-kBightBehind_m + 0.5 * i * layout.track_m, -kBightBelow_m};
      start.recline_rad =
          layout.least_recline_rad + (j + 0.5) / 4 * (layout.most_recline_rad - layout.least_recline_rad);
      const SeatFit fit = grown_from(start, layout, capped, options);
      // The most points; an occupant's lines are shorter than the seat's.
      if (fit.found && fit.cushion_points + fit.back_points > best.cushion_points + best.back_points) best = fit;
    }
  }
  best.hidden = hidden_share(best.pose, capped, options);
  best.found = best.found && best.hidden <= options.most_hidden;
  return best;
}

void SeatWatch::add(const SeatFit& fit) {
  ++since_seen_;
  if (!fit.found) return;
  if (frames_ > 0) {
    const SeatPose before = seat().pose;
    if ((fit.pose.bight - before.bight).norm() > kMoved_m ||
        std::abs(fit.pose.recline_rad - before.recline_rad) > kMoved_rad) {
      *this = {};
    }
  }
  last_ = fit;
  since_seen_ = 0;
  ++frames_;
  const SeatPose& pose = fit.pose;
  const Eigen::Vector4d value(pose.bight.x(), pose.bight.y(), pose.recline_rad, pose.cushion_pitch_rad);
  const Eigen::Vector4d off = value - mean_;
  mean_ += off / frames_;
  squares_ += off.cwiseProduct(value - mean_);  // Welford 1962
  const Eigen::Vector3d sigma(fit.bight_sigma_m.x(), fit.bight_sigma_m.y(), fit.recline_sigma_rad);
  variance_ += (sigma.cwiseAbs2() - variance_) / frames_;
}

SeatFit SeatWatch::seat() const {
  SeatFit seat = last_;
  if (frames_ == 0) return seat;
  seat.pose = {mean_.head<2>(), mean_[2], mean_[3]};
  Eigen::Vector3d variance = variance_;
  if (frames_ >= 3) variance += squares_.head<3>() / (frames_ - 1.0) / frames_;
  seat.bight_sigma_m = variance.head<2>().cwiseSqrt();
  seat.recline_sigma_rad = std::sqrt(variance[2]);
  return seat;
}

}  // namespace raybundle
