// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "raybundle/synthetic/gaussian_beam.hpp"
#include "seen_board.hpp"

namespace raybundle {

/// What is behind the board: a sphere around the rig.
class Background {
 public:
  Background(double radius_m, const Rigid3& target_from_rig)
      : radius_m_(radius_m), centre_(target_from_rig.translation) {}

  /// Where a ray that starts within the sphere leaves it.
  Eigen::Vector3d crossing(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

  /// Towards the rig.
  Eigen::Vector3d normal(const Eigen::Vector3d& place) const { return (centre_ - place).normalized(); }

 private:
  double radius_m_;
  Eigen::Vector3d centre_;
};

/// What the laser lights, for a camera.
class LaserLight {
 public:
  LaserLight(const SimulatedRig& rig, const SimulatedCamera& camera, const BoardScene& scene, const SeenBoard& seen,
             const Background& background, const Rigid3& target_from_rig);

  /// Adds a beam's spot, on the board and behind it [W/m² times albedo].
  void add(const GaussianBeam& beam, const LensBlur& blur, LightImage& image) const;

  /// Pixel where the camera sees a place of the target's frame; nothing where it does not project into the image.
  std::optional<Eigen::Vector2d> pixel_of(const Eigen::Vector3d& x_in_target) const;

 private:
  struct Patch;
  enum class Shadow { kNone, kPart, kWhole };

  Patch patch_around(const std::vector<Eigen::Vector3d>& places) const;
  Shadow shadow_of(const GaussianBeam& beam, const std::vector<Eigen::Vector3d>& offsets) const;
  void add_on_board(const GaussianBeam& beam, const std::vector<Eigen::Vector3d>& offsets, const LensBlur& blur,
                    LightImage& image) const;
  void add_behind(const GaussianBeam& beam, const std::vector<Eigen::Vector3d>& offsets, const LensBlur& blur,
                  LightImage& image) const;

  const SimulatedRig* rig_;
  const SimulatedCamera* camera_;
  const BoardScene* scene_;
  const SeenBoard* seen_;
  const Background* background_;
  Rigid3 camera_from_target_;
};

}  // namespace raybundle
