// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "raybundle/cockpit/cockpit.hpp"

namespace raybundle {

/// Where a ray first meets the cabin.
struct CabinHit {
  double distance_m = 0.0;
  Eigen::Vector3d x_in_vehicle = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< of unit length, towards the ray's origin, smooth over the mesh
  Eigen::Vector3f place = Eigen::Vector3f::Zero();   ///< in the body's own coordinates
  int mesh = -1;                                     ///< index into Cockpit::meshes
};

/// A cabin that rays can be sent into. Tracing is safe from several threads.
class CabinScene {
 public:
  explicit CabinScene(Cockpit cockpit);

  const Cockpit& cockpit() const { return *cockpit_; }

  /// What a ray meets first; nothing when it leaves the cabin through a window.
  ///
  /// @param direction  of unit length
  std::optional<CabinHit> first_hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

  /// The same for many rays from one origin, eight at a time; a direction that is NaN is no ray, mesh -1 no hit.
  ///
  /// @param hits  as many as directions
  void first_hits(const Eigen::Vector3d& origin, std::span<const Eigen::Vector3d> directions,
                  std::span<CabinHit> hits) const;

  /// Whether something lies between two places; surfaces within 1 mm of either end do not count.
  bool blocked(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;

  /// The same for many hits and one place, eight at a time; hits that are none stay as they are.
  ///
  /// @param dark  as many as hits: 1 where something lies between
  void blocked(std::span<const CabinHit> from, const Eigen::Vector3d& to, std::span<std::uint8_t> dark) const;

  /// Share of the light that falls on a hit which comes back; its pattern included.
  double albedo(const CabinHit& hit) const;

 private:
  std::shared_ptr<const Cockpit> cockpit_;
  std::shared_ptr<void> traced_;  ///< Embree's scene
};

}  // namespace raybundle
