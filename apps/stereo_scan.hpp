// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/geometry/rigid3.hpp"
#include "raybundle/occupancy/monitor.hpp"
#include "raybundle/occupancy/scan.hpp"
#include "raybundle/stereo/ray_grid.hpp"

namespace raybundle::apps {

/// Points of a pair in the vehicle, as dense and as far to the sides as cases of stereo are learnt: by pairs of
/// 128x128 pixels that show 110 degrees.
class StereoScan {
 public:
  /// @throws Error(kBadInput) when the pair has fewer pixels, or shows too little
  StereoScan(const RectifiedCamera& camera, const Rigid3& vehicle_from_rectified);

  /// Those of a learnt pair at least: of a narrower one, some never end.
  int rays() const;

  /// Thresholds for these points.
  MonitorOptions monitor_options() const;

  /// @return  valid until the next call
  Scan of(const StereoFrame& frame);

 private:
  RayGrid grid_;
  Rigid3 vehicle_from_rectified_;
  std::vector<ScenePoint> points_;
};

}  // namespace raybundle::apps
