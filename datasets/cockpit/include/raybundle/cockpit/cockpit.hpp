// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "raybundle/cockpit/truth.hpp"

namespace raybundle {

/// What a mesh belongs to.
enum class CabinPart : std::uint8_t { kCar, kDashboard, kSeat, kHead, kBody, kChildSeat, kObject, kBlanket };

/// How a surface looks in the near infrared. Its pattern is a function of the mesh's own coordinates: it moves with it.
struct CabinMaterial {
  double albedo = 0.4;
  double specular = 0.0;   ///< share of light that is mirrored, in a lobe about the mirrored direction
  double gloss = 20.0;     ///< exponent of the lobe's cosine
  double contrast = 0.3;   ///< of the pattern: standard deviation of the albedo over its mean
  double grain_m = 0.01;   ///< size of the pattern's finest features; coarser ones stand beside them
  std::uint32_t seed = 0;  ///< of the pattern
};

/// A body's surface of triangles; its normals are smooth.
struct CabinMesh {
  CabinPart part = CabinPart::kCar;
  CabinMaterial material;
  std::vector<Eigen::Vector3f> vertices;  ///< [m] in the vehicle frame
  std::vector<Eigen::Vector3f> places;    ///< [m] of the vertices in the body's own coordinates, for its pattern
  std::vector<Eigen::Vector3i> triangles;
};

/// Light in the cabin, within the band that the cameras see.
struct CabinLight {
  double ambient_W_m2 = 1.0;
  double sun_W_m2 = 0.0;                                     ///< on a surface that faces the sun; 0: it does not shine
  Eigen::Vector3d sun_direction = Eigen::Vector3d::UnitZ();  ///< towards it
};

/// Where scenes come from. Cars, seats, bodies, child seats, objects and sensors of the two have no shape, proportion
/// or distribution in common: what is learnt on one and works on the other has not been learnt by heart.
enum class CockpitGenerator : std::uint8_t { kTraining, kTest };

/// Which scene. The same request gives the same bits.
struct CockpitRequest {
  CockpitGenerator generator = CockpitGenerator::kTraining;
  std::uint64_t seed = 1;
  std::optional<CabinClass> wanted = {};  ///< else drawn, all classes alike
  double time_s = 0.0;                    ///< passengers move, nothing else does
};

/// A cabin and what is in it.
struct Cockpit {
  CabinLayout layout;
  CockpitTruth truth;
  CabinLight light;
  std::vector<CabinMesh> meshes;
};

/// Draws a cabin.
Cockpit make_cockpit(const CockpitRequest& request);

}  // namespace raybundle
