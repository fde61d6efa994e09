// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "raybundle/camera/camera.hpp"
#include "raybundle/geometry/rigid3.hpp"
#include "raybundle/scene/observation.hpp"
#include "raybundle/synthetic/rig.hpp"

namespace raybundle {

/// What a sensor reads out, row by row; values are below 2^bits.
struct GreyImage {
  ImageSize size;
  int bits = 8;
  std::vector<std::uint16_t> values = {};

  std::uint16_t at(int x, int y) const { return values[static_cast<std::size_t>(y) * size.width + x]; }
};

/// Where a beam's spot is seen. A spot whose centre is out of sight is not listed, even where its rim lights the edge
/// of the board.
struct RenderedDot {
  int beam = 0;                                     ///< index into ViewRenderer::beams()
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< of the place where the beam's axis meets the surface
  bool on_board = true;                             ///< else on what is behind the board
  bool on_ink = false;
  double peak_grey = 0.0;   ///< light of the laser in that pixel without noise and speckle, in grey values
  double under_grey = 0.0;  ///< grey value of that pixel without laser and noise
};

/// An image pair of one board pose, and the truth about it.
struct RenderedView {
  GreyImage off;                     ///< the laser is off
  GreyImage on;                      ///< the laser is on; without values when the rig has no emitter
  std::vector<Observation> corners;  ///< true pixels of the board's points that the camera sees
  std::vector<RenderedDot> dots;     ///< of all beams whose spot is seen, in the order of the beams
};

struct RenderOptions {
  std::uint64_t seed = 1;    ///< of noise and speckle
  std::uint64_t stream = 0;  ///< noise of different streams of one seed is independent: a view
  bool noise = true;         ///< shot and read noise; grey values are rounded without, too
  bool speckle = true;
};

/// Renders what the cameras of a rig see of its board. What does not depend on the board's pose is computed once;
/// render may be called from several threads.
///
/// A pixel's light is the integral over its square of the light of the scene, blurred by the lens's Gaussian spot. It
/// is a weighted sum over 4 × 4 cells of each pixel; of every cell the part that is ink and the part that is board are
/// areas of clipped polygons, not counts of samples, so that edges are where they should be to 0.001 px. Grey values:
/// 2^bits - 1 times (black_level + electrons / full_well_e), electrons = full_well_e exposure albedo W_m2 / white_W_m2
/// cos(angle / 2)^vignetting.
class ViewRenderer {
 public:
  /// @param warmer_K  the emitter's temperature above the one of its wavelength
  /// @throws Error(kBadInput) when the board is not flat, or bent over
  explicit ViewRenderer(const SimulatedRig& rig, double warmer_K = 0.0);

  /// The image pair of a camera. The same arguments give the same bits.
  RenderedView render(int camera, const Rigid3& rig_from_target, const RenderOptions& options = {}) const;

  const std::vector<EmittedBeam>& beams() const;

 private:
  struct Scene;
  std::shared_ptr<const Scene> scene_;
};

/// One image pair; ViewRenderer is faster for many.
RenderedView render_view(const SimulatedRig& rig, int camera, const Rigid3& rig_from_target,
                         const RenderOptions& options = {});

/// Standard deviation of a grey value by shot noise, read noise and rounding.
///
/// @param grey  mean grey value, black level included, not saturated
double grey_sigma(const SimulatedSensor& sensor, double grey);

}  // namespace raybundle
