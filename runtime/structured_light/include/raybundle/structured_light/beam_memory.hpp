// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "raybundle/structured_light/candidates.hpp"

namespace raybundle {

/// How far each beam lies off its calibrated line, across its epipolar plane, as the dots of a running sensor tell. A
/// line has an offset and a slope there; what the calibration states of them is where it begins, and what it goes back
/// to as it forgets. All memory is taken at the start.
class BeamMemory {
 public:
  /// @param frames  over which the weight of a dot falls to 1/e
  BeamMemory(const BeamSet& beams, int frames);

  /// Of BeamGeometry::off_plane() at a place of a beam.
  struct Off {
    double mean = 0.0;
    double variance = 0.0;
    Eigen::RowVector2d by_calibration;  ///< what an error of the calibrated offset [m] and slope still does, unlearnt
  };
  Off off(int beam, double along_m, double inverse_distance) const;

  /// Forgets a little: to be called for each frame.
  void fade();

  /// @param off       measured, of off_plane()
  /// @param variance  of it by the dot
  void learn(int beam, double along_m, double inverse_distance, double off, double variance);

 private:
  struct Line {
    Eigen::Matrix2d prior;  ///< information of the calibration
    Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
  };

  double kept_;  ///< of each weight, frame by frame
  std::vector<Line> lines_;
};

}  // namespace raybundle
