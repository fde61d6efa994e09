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

/// The pose that most pairs agree on so far, and which pairs those are.
class Consensus {
 public:
  Consensus(std::span<const Eigen::Vector3d> points, std::span<const Eigen::Vector3d> rays, double threshold_rad)
      : points_(points),
        rays_(rays),
        threshold_rad_(threshold_rad),
        inlier_(points.size()),
        trial_inlier_(points.size()),
        best_cost_(static_cast<double>(points.size()) * threshold_rad * threshold_rad) {}

  bool found() const { return found_; }
  double share() const {
    return static_cast<double>(std::ranges::count(inlier_, 1)) / static_cast<double>(points_.size());
  }

  /// Takes a pose that is better; whether it is.
  bool consider(const Rigid3& pose) {
    const double cost = truncated_cost(points_, rays_, pose, threshold_rad_, trial_inlier_);
    if (!(cost < best_cost_)) return false;
    best_ = pose;
    best_cost_ = cost;
    found_ = true;
    inlier_.swap(trial_inlier_);
    return true;
  }

  /// Both candidates of the ambiguity, from all pairs that fit, until nothing changes.
  void improve() {
    for (int round = 0; round < 5; ++round) {
      std::vector<Eigen::Vector3d> points;
      std::vector<Eigen::Vector3d> rays;
      for (std::size_t i = 0; i < points_.size(); ++i) {
        if (!inlier_[i]) continue;
        points.push_back(points_[i]);
        rays.push_back(rays_[i]);
      }
      if (points.size() < 4) return;
      Rigid3 refined = best_;
      refine_on_rays(points, rays, refined, kRefineIterations);
      bool better = consider(refined);
      for (const TargetPose& pose : target_pose(points, rays)) better |= consider(pose.camera_from_target);
      if (!better) return;
    }
  }

  /// With the rms of the pairs that fit; nothing when they are too few.
  std::optional<TargetPose> pose() const {
    double sum = 0.0;
    int fitting = 0;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (!inlier_[i]) continue;
      sum += ((best_ * points_[i]).normalized() - rays_[i]).squaredNorm();
      ++fitting;
    }
    if (fitting < 4) return std::nullopt;
    return TargetPose{best_, std::sqrt(sum / fitting)};
  }

 private:
  std::span<const Eigen::Vector3d> points_, rays_;
  double threshold_rad_;
  std::vector<char> inlier_, trial_inlier_;
  Rigid3 best_;
  double best_cost_;
  bool found_ = false;
};

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
  Consensus consensus(points_in_target, rays_in_camera, threshold_rad);
  int needed = kMaxSamples;
  for (int sample = 0; sample < needed; ++sample) {
    const std::size_t index[3] = {draw(), draw(), draw()};
    if (index[0] == index[1] || index[0] == index[2] || index[1] == index[2]) continue;
    Eigen::Vector3d points[3];
    Eigen::Vector3d rays[3];
    for (int k = 0; k < 3; ++k) {
      points[k] = points_in_target[index[k]];
      rays[k] = rays_in_camera[index[k]];
    }
    bool better = false;
    for (const Rigid3& pose : three_point_poses(points, rays)) better |= consensus.consider(pose);
    if (!better) continue;
    consensus.improve();
    const double share = consensus.share();
    const double miss = 1.0 - share * share * share;  // a sample with a wrong pair in it
    const double enough = miss < 1e-12 ? 0.0 : std::log(1e-6) / std::log(miss);
    needed = std::min(kMaxSamples, sample + 1 + static_cast<int>(std::min(enough, 1.0 * kMaxSamples)));
  }
  if (!consensus.found()) return std::nullopt;
  consensus.improve();
  return consensus.pose();
}

}  // namespace raybundle
