// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/initialize/target_pose.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "linear_pose.hpp"
#include "pose_refinement.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

constexpr int kRefineIterations = 30;

void require_equal_sizes(std::size_t points, std::size_t rays) {
  if (points == rays) return;
  throw Error(ErrorKind::kBadInput, "a pose needs one ray for each point; got " + std::to_string(points) +
                                        " points and " + std::to_string(rays) + " rays");
}

/// True when most of the points lie on their rays' side of the camera.
bool in_front(std::span<const Eigen::Vector3d> points, std::span<const Eigen::Vector3d> rays, const Rigid3& pose) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < points.size(); ++i) count += (pose * points[i]).dot(rays[i]) > 0;
  return 2 * count > points.size();
}

/// Starts that are refined: linear solutions where there are enough points, else exact ones of three points.
std::vector<Rigid3> starting_poses(std::span<const Eigen::Vector3d> points, std::span<const Eigen::Vector3d> rays,
                                   const PrincipalFrame& frame) {
  std::vector<Rigid3> starts;
  if (frame.spread[2] < 0.3 * frame.spread[0]) {
    if (const auto pose = linear_planar_pose(points, rays, frame)) starts.push_back(*pose);
  }
  if (frame.spread[2] > 0.01 * frame.spread[0]) {
    if (points.size() >= 6) {
      if (const auto pose = linear_spatial_pose(points, rays, frame)) starts.push_back(*pose);
    }
    if (points.size() < 8) {
      for (const Rigid3& pose : three_point_poses(points.data(), rays.data())) starts.push_back(pose);
    }
  }
  return starts;
}

/// Adds a refined pose unless it is there already.
void add(std::vector<TargetPose>& poses, const TargetPose& pose) {
  for (const TargetPose& known : poses) {
    if (angle_between(known.camera_from_target, pose.camera_from_target) < 1e-3 &&
        std::abs(known.rms_rad - pose.rms_rad) < 1e-3 * known.rms_rad + 1e-9) {
      return;
    }
  }
  poses.push_back(pose);
}

/// Sum over the pairs of squared chords, cut off at the threshold, and the pairs below it.
double truncated_cost(std::span<const Eigen::Vector3d> points, std::span<const Eigen::Vector3d> rays,
                      const Rigid3& pose, double threshold, std::vector<char>& inlier) {
  const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
  const double threshold2 = threshold * threshold;
  double cost = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d x = rotation * points[i] + pose.translation;
    const double chord2 = (x.normalized() - rays[i]).squaredNorm();
    inlier[i] = chord2 < threshold2;
    cost += inlier[i] ? chord2 : threshold2;
  }
  return cost;
}

}  // namespace

std::vector<TargetPose> target_pose(std::span<const Eigen::Vector3d> points_in_target,
                                    std::span<const Eigen::Vector3d> rays_in_camera) {
  require_equal_sizes(points_in_target.size(), rays_in_camera.size());
  if (points_in_target.size() < 4) return {};
  const PrincipalFrame frame = principal_frame(points_in_target);
  if (frame.collinear()) return {};

  std::vector<TargetPose> poses;
  const auto refine = [&](Rigid3 pose) {
    const double squares = refine_on_rays(points_in_target, rays_in_camera, pose, kRefineIterations);
    const double rms = std::sqrt(squares / static_cast<double>(points_in_target.size()));
    if (in_front(points_in_target, rays_in_camera, pose)) add(poses, {pose, rms});
  };
  for (const Rigid3& start : starting_poses(points_in_target, rays_in_camera, frame)) {
    refine(start);
    if (frame.spread[2] < 0.3 * frame.spread[0]) refine(mirrored_pose(start, frame));
  }
  if (!poses.empty()) refine(mirrored_pose(poses.front().camera_from_target, frame));
  std::ranges::stable_sort(poses, {}, &TargetPose::rms_rad);
  if (frame.planar() && poses.size() > 2) poses.resize(2);
  return poses;
}

std::optional<TargetPose> robust_target_pose(std::span<const Eigen::Vector3d> points_in_target,
                                             std::span<const Eigen::Vector3d> rays_in_camera, double threshold_rad,
                                             unsigned seed) {
  require_equal_sizes(points_in_target.size(), rays_in_camera.size());
  const std::size_t count = points_in_target.size();
  if (count < 4) return std::nullopt;

  constexpr int kMaxSamples = 300;
  std::mt19937 random(seed);
  const auto draw = [&] { return static_cast<std::size_t>(random() % count); };
  std::vector<char> inlier(count);
  std::vector<char> trial_inlier(count);
  Rigid3 best;
  double best_cost = static_cast<double>(count) * threshold_rad * threshold_rad;
  bool found = false;
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3d> rays;

  const auto consider = [&](const Rigid3& pose) {
    const double cost = truncated_cost(points_in_target, rays_in_camera, pose, threshold_rad, trial_inlier);
    if (!(cost < best_cost)) return false;
    best = pose;
    best_cost = cost;
    found = true;
    inlier.swap(trial_inlier);
    return true;
  };
  const auto improve = [&] {  // both candidates of the ambiguity, from all pairs that fit, until nothing changes
    for (int round = 0; round < 5; ++round) {
      points.clear();
      rays.clear();
      for (std::size_t i = 0; i < count; ++i) {
        if (!inlier[i]) continue;
        points.push_back(points_in_target[i]);
        rays.push_back(rays_in_camera[i]);
      }
      bool better = false;
      Rigid3 refined = best;
      if (points.size() >= 4) {
        refine_on_rays(points, rays, refined, kRefineIterations);
        better = consider(refined);
        for (const TargetPose& pose : target_pose(points, rays)) better |= consider(pose.camera_from_target);
      }
      if (!better) return;
    }
  };

  int needed = kMaxSamples;
  for (int sample = 0; sample < needed; ++sample) {
    std::size_t index[3] = {draw(), draw(), draw()};
    if (index[0] == index[1] || index[0] == index[2] || index[1] == index[2]) continue;
    Eigen::Vector3d sample_points[3];
    Eigen::Vector3d sample_rays[3];
    for (int k = 0; k < 3; ++k) {
      sample_points[k] = points_in_target[index[k]];
      sample_rays[k] = rays_in_camera[index[k]];
    }
    bool better = false;
    for (const Rigid3& pose : three_point_poses(sample_points, sample_rays)) better |= consider(pose);
    if (!better) continue;
    improve();
    const double share = static_cast<double>(std::ranges::count(inlier, 1)) / static_cast<double>(count);
    const double miss = 1.0 - share * share * share;  // a sample with a wrong pair in it
    const double enough = miss < 1e-12 ? 0.0 : std::log(1e-6) / std::log(miss);
    needed = std::min(kMaxSamples, sample + 1 + static_cast<int>(std::min(enough, 1.0 * kMaxSamples)));
  }
  if (!found) return std::nullopt;
  improve();

  double sum = 0.0;
  int fitting = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (!inlier[i]) continue;
    sum += ((best * points_in_target[i]).normalized() - rays_in_camera[i]).squaredNorm();
    ++fitting;
  }
  if (fitting < 4) return std::nullopt;
  return TargetPose{best, std::sqrt(sum / fitting)};
}

}  // namespace raybundle
