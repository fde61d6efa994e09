// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "raybundle/scene/calibration.hpp"
#include "raybundle/synthetic/emitter.hpp"
#include "raybundle/synthetic/random.hpp"

namespace raybundle::testing {

/// Half-spaces and ellipsoids as a sensor under the roof sees a passenger seat: floor, door, dashboard, cushion, back,
/// headrest and, mostly, somebody in it. All in the rig frame; z is where the sensor looks.
class CabinScene {
 public:
  /// Every seed is another cabin.
  explicit CabinScene(std::uint64_t seed);

  /// Distance along a line from `from_m` on to the first surface.
  std::optional<double> first_hit(const Line3& line, double from_m) const;

  /// Whether nothing is between two points.
  bool visible(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;

 private:
  struct Ellipsoid {
    Eigen::Vector3d centre;
    Eigen::Matrix3d sphere_from_rig;  ///< turns and scales it to the unit sphere
  };
  struct Plane {
    Eigen::Vector3d normal;  ///< towards the sensor
    double offset_m = 0.0;
  };

  void add_ellipsoid(const Eigen::Vector3d& centre, const Eigen::Vector3d& radii, const Eigen::Vector3d& turn);
  void add_box(const Eigen::Vector3d& centre, const Eigen::Vector3d& half, const Eigen::Vector3d& turn);

  std::vector<Ellipsoid> ellipsoids_;
  std::vector<Plane> planes_;
  struct Box {
    Eigen::Vector3d centre, half;
    Eigen::Matrix3d box_from_rig;
  };
  std::vector<Box> boxes_;
};

/// A dot with the beam that made it, or kUnlabelled for one that no beam made.
struct SceneDot {
  Dot dot;
  int beam = kUnlabelled;                                 ///< LaserGrid::index
  Eigen::Vector3d x_in_camera = Eigen::Vector3d::Zero();  ///< of a beam's dot [m]
};

struct SceneDotOptions {
  double sigma_px = 0.1;
  double missed = 0.1;     ///< share of the dots that are seen
  double spurious = 0.05;  ///< over those that are seen, anywhere in the image
};

/// The dots that a camera sees of the beams in a scene, in random order.
std::vector<SceneDot> dots_in(const CabinScene& scene, const RigCamera& camera, const std::vector<EmittedBeam>& beams,
                              const LaserGrid& grid, const SceneDotOptions& options, Random& random);

}  // namespace raybundle::testing
