// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/camera/camera_model.hpp"
#include "raybundle/camera/plane_distortion.hpp"

namespace raybundle {

/// Perspective lens with radial and decentring distortion, x = X/Z, y = Y/Z, r² = x² + y²:
///
///   s  = 1 + k1 r² + k2 r⁴ + k3 r⁶
///   x' = s x + 2 p1 x y + p2 (r² + 2 x²)
///   y' = s y + p1 (r² + 2 y²) + 2 p2 x y
///
/// Source: Brown, "Close-range camera calibration", Photogrammetric Engineering 1971; terms and order as in
/// cv::projectPoints with 5 coefficients.
/// Domain: z > 0, and up to the angle where r s(r) folds back, which a lens with k1 < 0 usually has.
struct BrownConrady : DistortedPinhole<5> {
  static constexpr std::string_view kName = "brown_conrady";
  static constexpr std::array<std::string_view, 5> kShapeNames{"k1", "k2", "p1", "p2", "k3"};
  static constexpr std::array<double, 5> kStartShape{};
  static constexpr std::array kExamples{ExampleShape<5>{{-0.35, 0.05, 0.0002, -0.0003, 0.0}, 0.6},
                                        ExampleShape<5>{{0.12, -0.2, 0.001, -0.002, 0.11}, 0.7},
                                        ExampleShape<5>{{-0.05, 0.02, -0.001, 0.0005, 0.004}, 1.1}};
  static constexpr std::array kForeignNames{
      ForeignName{"opencv", "plumb_bob"},      ForeignName{"ros", "plumb_bob"},
      ForeignName{"kalibr", "pinhole-radtan"}, ForeignName{"mrcal", "LENSMODEL_OPENCV5"},
      ForeignName{"colmap", "OPENCV"},         ForeignName{"camodocal", "PINHOLE"}};
};
static_assert(CameraModel<BrownConrady>);

}  // namespace raybundle
