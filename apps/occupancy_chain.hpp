// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "occupancy_scenes.hpp"
#include "raybundle/cockpit/cabin_renderer.hpp"

namespace raybundle::apps {

struct Bytes;

/// Measures simulated cabins as the device does: images are rendered, and the runtime makes points of them. Laser:
/// dots, labels, points; stereo: rectified pair, matches, points.
class ChainSource {
 public:
  /// @param request  its time does not matter
  explicit ChainSource(const SceneRequest& request);
  ChainSource(ChainSource&&) noexcept;
  ~ChainSource();

  /// Frames are to be asked for in their order: the laser's runtime follows its wavelength.
  MeasuredScene at(double time_s);

  /// A cabin that is there already, as this sensor sees it.
  MeasuredScene measured(const CabinScene& scene, double time_s);

 private:
  struct Runtime;
  Bytes image(const CabinScene& scene, int camera, bool laser, double time_s) const;
  void measure_dots(const CabinScene& scene, double time_s, MeasuredScene& measured);
  void measure_pair(const CabinScene& scene, double time_s, MeasuredScene& measured);

  SceneRequest request_;
  CabinSensor sensor_;
  CabinRenderer renderer_;
  std::unique_ptr<Runtime> runtime_;
};

}  // namespace raybundle::apps
