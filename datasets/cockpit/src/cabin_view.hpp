// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/cockpit/cabin_scene.hpp"
#include "raybundle/synthetic/camera_rays.hpp"
#include "raybundle/synthetic/gaussian_beam.hpp"
#include "raybundle/synthetic/lens_blur.hpp"

namespace raybundle {

/// A camera in the cabin and its rays.
struct CabinView {
  const SimulatedCamera& camera;
  const CameraRays& rays;
  Rigid3 vehicle_from_camera;

  const Eigen::Vector3d& eye() const { return vehicle_from_camera.translation; }

  /// Ray of a place in a pixel, of unit length; NaN where the lens sends none.
  ///
  /// @param u, v  0 to 1
  Eigen::Vector3d direction(int x, int y, double u, double v) const;
};

/// Adds the spots that a beam makes on whatever it meets [W/m² times albedo].
void add_beam(const CabinScene& scene, const CabinView& view, const GaussianBeam& beam_in_vehicle, const LensBlur& blur,
              LightImage& image);

}  // namespace raybundle
