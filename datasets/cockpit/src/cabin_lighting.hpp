// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "raybundle/cockpit/cabin_scene.hpp"
#include "raybundle/cockpit/sensor.hpp"

namespace raybundle {

/// Light of the flood lamp, the sun and the sky on what rays met.
class CabinLighting {
 public:
  CabinLighting(const CabinScene& scene, const CabinSensor& sensor);

  /// Light times albedo that comes back to the eye [W/m² on a white surface]; 0 where a ray met nothing.
  ///
  /// @param eye  in the vehicle frame
  void shine(const Eigen::Vector3d& eye, std::span<const CabinHit> hits, std::span<float> light) const;

 private:
  double lamp_W_m2(const CabinHit& hit) const;  ///< without albedo and shadows

  const CabinScene* scene_;
  double illuminator_W_m2_;
  Eigen::Vector3d lamp_, axis_, sun_;  // in the vehicle frame; the sun's a place far away
};

}  // namespace raybundle
