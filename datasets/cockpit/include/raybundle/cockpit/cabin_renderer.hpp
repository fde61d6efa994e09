// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "raybundle/cockpit/cabin_scene.hpp"
#include "raybundle/cockpit/sensor.hpp"
#include "raybundle/synthetic/render.hpp"

namespace raybundle {

struct CabinImageOptions {
  std::uint64_t seed = 1;    ///< of noise and speckle
  std::uint64_t stream = 0;  ///< noise of different streams of one seed is independent: a frame
  bool noise = true;         ///< shot and read noise, speckle
  bool laser = false;        ///< the emitter is on
  int samples = 2;           ///< rays for each pixel, each way: 1, 2 or 4
};

/// What a camera's pixels see, row by row; mesh -1 where they see nothing, or lie outside of the used field.
struct CabinDepth {
  ImageSize size;
  std::vector<CabinHit> hits;
};

/// Looks into cabins with the cameras of one sensor: what depends on the sensor only is computed once. Its functions
/// may be called from several threads, and the same arguments give the same bits.
class CabinRenderer {
 public:
  explicit CabinRenderer(const CabinSensor& sensor);

  const CabinSensor& sensor() const;

  /// Flood light, daylight and, where asked for, the laser; lens, vignetting and sensor are those of ViewRenderer.
  GreyImage image(const CabinScene& scene, int camera, const CabinImageOptions& options = {}) const;

  /// Truth at the centres of the pixels.
  CabinDepth depth(const CabinScene& scene, int camera) const;

 private:
  struct Tables;
  std::shared_ptr<const Tables> tables_;
};

/// Mean of the places of a head that a camera sees, each weighted by the surface that its pixel shows; nothing when it
/// sees none. It lies some centimetres from the head's centre towards the camera.
///
/// @param eye  the camera's place in the vehicle
std::optional<Eigen::Vector3d> visible_head_centroid(const CabinDepth& depth, const Cockpit& cockpit,
                                                     const Eigen::Vector3d& eye);

}  // namespace raybundle
