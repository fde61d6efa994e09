// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "board_agreement.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "lens_bundle.hpp"
#include "linear_pose.hpp"
#include "raybundle/geometry/rotation.hpp"

namespace raybundle {
namespace {

constexpr std::size_t kMaxHypotheses = 60;

/// Rigid motion of the board that takes each point to its image under a symmetry.
Rigid3 motion_of(const Target& target, const TargetSymmetry& symmetry) {
  const double count = static_cast<double>(target.points.size());
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector3d image_centre = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < target.points.size(); ++i) {
    centre += target.points[i].x_in_target / count;
    image_centre += target.find(symmetry.ids[i])->x_in_target / count;
  }
  Eigen::Matrix3d correlation = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < target.points.size(); ++i) {
    correlation += (target.find(symmetry.ids[i])->x_in_target - image_centre) *
                   (target.points[i].x_in_target - centre).transpose();
  }
  const Eigen::Matrix3d rotation = nearest_rotation(correlation);
  return {Eigen::Quaterniond(rotation), image_centre - rotation * centre};
}

PosedView posed_view(const CalibrationProblem& problem, int index, const Rigid3& pose) {
  const TargetView& view = problem.views[index];
  const Target& target = problem.targets[view.target];
  PosedView posed;
  posed.view = index;
  posed.camera = view.camera;
  posed.camera_from_target.push_back(pose);
  for (const TargetSymmetry& symmetry : target.symmetries) {
    posed.camera_from_target.push_back(pose * motion_of(target, symmetry).inverse());
  }
  std::vector<Eigen::Vector3d> points;
  for (const TargetPoint& point : target.points) points.push_back(point.x_in_target);
  posed.centre_in_target = principal_frame(points).centre;

  // A board's tilt shows by foreshortening, to first order when it is tilted and to second when it faces the camera.
  points.clear();
  for (const Observation& observation : view.observations) {
    if (const TargetPoint* point = target.find(observation.point_id)) points.push_back(point->x_in_target);
  }
  const PrincipalFrame frame = principal_frame(points);
  const Eigen::Vector3d sight = pose * frame.centre;
  const Eigen::Vector3d normal = pose.rotation * Eigen::Vector3d(frame.local_from_target.row(2));
  const double angular_size = std::sqrt(frame.spread[0] * frame.spread[1]) / sight.norm();
  const double foreshortening = normal.cross(sight).norm() / sight.norm();
  posed.looseness = 1.0 / (std::sqrt(static_cast<double>(points.size())) * angular_size *
                           std::clamp(std::max(angular_size, foreshortening), 0.05, 0.5));
  return posed;
}

Rigid3 relative_pose(const PosedView& a, const PosedView& b, int b_labelling) {
  return b.camera_from_target[b_labelling] * a.camera_from_target[0].inverse();
}

using Pairs = std::vector<std::pair<const PosedView*, const PosedView*>>;

std::vector<double> sizes(const Pairs& pairs, const Rigid3& b_from_a) {
  std::vector<double> result;
  for (const auto& [a, b] : pairs) result.push_back(disagreement(*a, 0, *b, b_from_a).size);
  return result;
}

/// Mean of the relative poses of frames within the limit: rotations first, then where they put the boards.
Rigid3 mean_pose(const Pairs& pairs, const Rigid3& b_from_a, double limit) {
  Eigen::Matrix3d rotations = Eigen::Matrix3d::Zero();
  for (const auto& [a, b] : pairs) {
    const Disagreement d = disagreement(*a, 0, *b, b_from_a);
    if (!(d.size <= limit)) continue;
    const double weight = 1.0 / (a->looseness * a->looseness + b->looseness * b->looseness);
    rotations += weight * relative_pose(*a, *b, d.labelling).rotation.toRotationMatrix();
  }
  Rigid3 mean;
  mean.rotation = Eigen::Quaterniond(nearest_rotation(rotations)).normalized();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double weights = 0.0;
  for (const auto& [a, b] : pairs) {
    const Disagreement d = disagreement(*a, 0, *b, b_from_a);
    if (!(d.size <= limit)) continue;
    const double weight = 1.0 / (a->looseness * a->looseness + b->looseness * b->looseness);
    sum += weight * (b->camera_from_target[d.labelling] * b->centre_in_target -
                     mean.rotation * (a->camera_from_target[0] * a->centre_in_target));
    weights += weight;
  }
  if (!(weights > 0)) return b_from_a;
  mean.translation = sum / weights;
  return mean;
}

}  // namespace

std::vector<SharedBoard> shared_boards(const CalibrationProblem& problem,
                                       const std::vector<std::optional<Rigid3>>& camera_from_target) {
  std::map<std::pair<int, int>, SharedBoard> groups;
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    if (!camera_from_target[v]) continue;
    const TargetView& view = problem.views[v];
    SharedBoard& group = groups[{view.frame, view.target}];
    group.frame = view.frame;
    group.target = view.target;
    group.views.push_back(posed_view(problem, static_cast<int>(v), *camera_from_target[v]));
  }
  std::vector<SharedBoard> boards;
  for (auto& [key, group] : groups) {
    std::ranges::stable_sort(group.views, {}, &PosedView::camera);
    boards.push_back(std::move(group));
  }
  return boards;
}

Disagreement disagreement(const PosedView& a, int a_labelling, const PosedView& b, const Rigid3& b_from_a) {
  const Rigid3 expected = b_from_a * a.camera_from_target[a_labelling];
  const Eigen::Vector3d centre = expected * b.centre_in_target;
  Disagreement best;
  best.size = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < b.camera_from_target.size(); ++k) {
    Disagreement d;
    d.labelling = static_cast<int>(k);
    d.angle_rad = angle_between(expected, b.camera_from_target[k]);
    const Eigen::Vector3d seen = b.camera_from_target[k] * b.centre_in_target;
    d.distance_m = (centre - seen).norm();
    d.size = (d.angle_rad + d.distance_m / seen.norm()) / std::hypot(a.looseness, b.looseness);
    if (d.size < best.size) best = d;
  }
  return best;
}

PairConsensus pair_consensus(const Pairs& pairs) {
  PairConsensus consensus;
  double best = std::numeric_limits<double>::infinity();
  const std::size_t stride = (pairs.size() + kMaxHypotheses - 1) / kMaxHypotheses;
  for (std::size_t i = 0; i < pairs.size(); i += stride) {
    const auto& [a, b] = pairs[i];
    for (std::size_t k = 0; k < b->camera_from_target.size(); ++k) {
      const Rigid3 hypothesis = relative_pose(*a, *b, static_cast<int>(k));
      std::vector<double> errors = sizes(pairs, hypothesis);
      const double median = quantile(errors, 0.5);
      if (!(median < best)) continue;
      best = median;
      consensus.b_from_a = hypothesis;
    }
  }
  for (int round = 0; round < 3; ++round) {
    std::vector<double> errors = sizes(pairs, consensus.b_from_a);
    consensus.spread = 1.4826 * quantile(errors, 0.5);
    if (round < 2) {
      consensus.b_from_a = mean_pose(pairs, consensus.b_from_a, 0.5 * agreement_limit(consensus.spread));
    }
  }
  for (const double size : sizes(pairs, consensus.b_from_a)) {
    consensus.agreeing += size <= agreement_limit(consensus.spread);
  }
  return consensus;
}

double agreement_limit(double spread) {
  constexpr double kNoise = 1e-5;  // what a twentieth of a pixel does at least: exact data has no spread to measure by
  return 8.0 * std::max(spread, kNoise);
}

}  // namespace raybundle
