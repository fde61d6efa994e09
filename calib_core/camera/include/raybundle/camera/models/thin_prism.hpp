// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/camera/camera_model.hpp"
#include "raybundle/camera/plane_distortion.hpp"

namespace raybundle {

/// Perspective lens with rational radial profile, decentring and thin-prism distortion, x = X/Z, y = Y/Z, r² = x² + y²:
///
///   s  = (1 + k1 r² + k2 r⁴ + k3 r⁶) / (1 + k4 r² + k5 r⁴ + k6 r⁶)
///   x' = s x + 2 p1 x y + p2 (r² + 2 x²) + s1 r² + s2 r⁴
///   y' = s y + p1 (r² + 2 y²) + 2 p2 x y + s3 r² + s4 r⁴
///
/// Source: Weng, Cohen and Herniou, "Camera calibration with distortion models and accuracy evaluation", PAMI 1992
/// (the prism terms); terms and order as in cv::projectPoints with 12 coefficients.
/// Domain: z > 0, a positive denominator, and up to the angle where r s(r) folds back.
struct ThinPrism : DistortedPinhole<12> {
  static constexpr std::string_view kName = "thin_prism";
  static constexpr std::array<std::string_view, 12> kShapeNames{"k1", "k2", "p1", "p2", "k3", "k4",
                                                                "k5", "k6", "s1", "s2", "s3", "s4"};
  static constexpr std::array<double, 12> kStartShape{};
  static constexpr std::array kExamples{
      ExampleShape<12>{{0.9, 0.05, 0.0003, -0.0002, 0.0005, 1.25, 0.25, 0.01, 0.0008, -0.0001, -0.0006, 0.0002}, 1.1},
      ExampleShape<12>{{-0.2, 0.3, 0.001, -0.001, 0.02, 0.1, 0.25, 0.03, -0.002, 0.001, 0.003, -0.001}, 0.8}};
  static constexpr std::array kForeignNames{ForeignName{"opencv", "thin_prism"},
                                            ForeignName{"mrcal", "LENSMODEL_OPENCV12"}};
};
static_assert(CameraModel<ThinPrism>);

}  // namespace raybundle
