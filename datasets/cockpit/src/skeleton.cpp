// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "skeleton.hpp"

#include <algorithm>
#include <cmath>

#include "shapes.hpp"

namespace raybundle {
namespace {

struct TwoBones {
  Eigen::Vector3d middle, end;
};

// Two bones from `start` towards `target`, bent towards `bend`; straight when the target is too far.
TwoBones reach(const Eigen::Vector3d& start, const Eigen::Vector3d& target, double first, double second,
               const Eigen::Vector3d& bend) {
  const Eigen::Vector3d way = target - start;
  const double distance = std::clamp(way.norm(), 1.02 * std::abs(first - second) + 1e-3, 0.995 * (first + second));
  const Eigen::Vector3d along = way.normalized();
  const double foot = (distance * distance + first * first - second * second) / (2 * distance);
  const double height = std::sqrt(std::max(0.0, first * first - foot * foot));
  const Eigen::Vector3d across = (bend - bend.dot(along) * along).normalized();
  return {start + foot * along + height * across, start + distance * along};
}

}  // namespace

Skeleton skeleton_of(const BodySize& size, const Posture& posture) {
  Skeleton s;
  const Eigen::Quaterniond facing = about_z(posture.facing_rad);
  const Eigen::Quaterniond lean = facing * about_x(-posture.lean_left_rad);
  s.hips = posture.hips;
  s.vehicle_from_pelvis = lean * about_y(-posture.pelvis_recline_rad);
  s.waist = s.hips + s.vehicle_from_pelvis * Eigen::Vector3d(0, 0, size.hip_to_waist);
  const Eigen::Quaterniond spine = lean * about_y(-posture.chest_recline_rad);
  s.vehicle_from_chest = spine * about_z(posture.turn_left_rad);
  s.neck = s.waist + spine * Eigen::Vector3d(0, 0, size.waist_to_neck);
  const Eigen::Quaterniond head =
      lean * about_z(posture.turn_left_rad + posture.head_turn_left_rad) * about_y(posture.head_pitch_rad);
  // The neck's line lies between the chest's and the head's.
  const Eigen::Vector3d neck_line =
      (spine * Eigen::Vector3d::UnitZ() + head * Eigen::Vector3d(0.25, 0, 1)).normalized();
  s.head = {s.neck + size.neck_to_head * neck_line, size.head_semi_axes, head};
  const double foot_sign[] = {1.0, -1.0};
  for (int side = 0; side < 2; ++side) {
    const double left = foot_sign[side];
    s.shoulders[side] =
        s.neck + s.vehicle_from_chest * Eigen::Vector3d(0.01, left * size.shoulder_half, -0.04 * size.stature);
    const TwoBones arm = reach(s.shoulders[side], posture.hands[side], size.upper_arm, size.forearm,
                               facing * Eigen::Vector3d(-0.35, 0.3 * left, -1.0));
    s.elbows[side] = arm.middle;
    s.wrists[side] = arm.end;
    s.hand_tips[side] = arm.end + size.hand * (arm.end - arm.middle).normalized();
    s.hip_joints[side] = s.hips + s.vehicle_from_pelvis * Eigen::Vector3d(0, left * size.hip_half, 0);
    const TwoBones leg = reach(s.hip_joints[side], posture.feet[side], size.thigh, size.shank,
                               facing * Eigen::Vector3d(0.3, 0.12 * left, 1.0));
    s.knees[side] = leg.middle;
    s.ankles[side] = leg.end;
    s.toes[side] = leg.end + size.foot * posture.toes[side].normalized();
  }
  return s;
}

}  // namespace raybundle
