// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>

#include "raybundle/cockpit/truth.hpp"

namespace raybundle {

/// Lengths between joints and half widths of a body [m].
struct BodySize {
  double stature = 1.755;
  double hip_to_waist = 0.0, waist_to_neck = 0.0, neck_to_head = 0.0;
  double shoulder_half = 0.0, hip_half = 0.0;  ///< of joints from the middle
  double upper_arm = 0.0, forearm = 0.0, hand = 0.0, thigh = 0.0, shank = 0.0, foot = 0.0;
  Eigen::Vector3d head_semi_axes = Eigen::Vector3d::Zero();         ///< face, ear, crown
  double chest_depth = 0.0, waist_depth = 0.0, pelvis_depth = 0.0;  ///< half
  double chest_breadth = 0.0, waist_breadth = 0.0, pelvis_breadth = 0.0;
  double arm_radius = 0.0, wrist_radius = 0.0, thigh_radius = 0.0, knee_radius = 0.0, ankle_radius = 0.0;
  double neck_radius = 0.0;
};

/// How a body sits. Left comes first.
struct Posture {
  Eigen::Vector3d hips = Eigen::Vector3d::Zero();  ///< amid the hip joints
  double pelvis_recline_rad = 0.0;                 ///< of the line from hips to waist, to the rear
  double chest_recline_rad = 0.0;                  ///< of the line from waist to neck
  double lean_left_rad = 0.0;
  double turn_left_rad = 0.0;   ///< of the shoulders
  double facing_rad = 0.0;      ///< of the whole body about the vertical; pi: it looks to the rear
  double head_pitch_rad = 0.0;  ///< nod to the front
  double head_turn_left_rad = 0.0;
  std::array<Eigen::Vector3d, 2> hands = {};  ///< wrists reach for them as far as they can [vehicle frame]
  std::array<Eigen::Vector3d, 2> feet = {};   ///< ankles
  std::array<Eigen::Vector3d, 2> toes = {};   ///< directions
};

/// Joints in the vehicle frame; left comes first.
struct Skeleton {
  Eigen::Vector3d hips, waist, neck;
  Eigen::Quaterniond vehicle_from_pelvis, vehicle_from_chest;  ///< x to the front of the body, z along the spine
  HeadTruth head;
  std::array<Eigen::Vector3d, 2> shoulders, elbows, wrists, hand_tips, hip_joints, knees, ankles, toes;
};

/// Puts the body into the posture: elbows hang down and outwards, knees point up.
Skeleton skeleton_of(const BodySize& size, const Posture& posture);

}  // namespace raybundle
