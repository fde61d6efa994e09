// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/camera/camera_model.hpp"
#include "raybundle/camera/plane_distortion.hpp"

namespace raybundle {

/// Perspective lens with a rational radial profile and decentring distortion, x = X/Z, y = Y/Z, r² = x² + y²:
///
///   s  = (1 + k1 r² + k2 r⁴ + k3 r⁶) / (1 + k4 r² + k5 r⁴ + k6 r⁶)
///   x' = s x + 2 p1 x y + p2 (r² + 2 x²)
///   y' = s y + p1 (r² + 2 y²) + 2 p2 x y
///
/// Source: Claus and Fitzgibbon, "A rational function lens distortion model for general cameras", CVPR 2005 (the idea);
/// terms and order as in cv::projectPoints with 8 coefficients.
/// Domain: z > 0, a positive denominator, and up to the angle where r s(r) folds back.
struct Rational : DistortedPinhole<8> {
  static constexpr std::string_view kName = "rational";
  static constexpr std::array<std::string_view, 8> kShapeNames{"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
  static constexpr std::array<double, 8> kStartShape{};
  static constexpr std::array kExamples{ExampleShape<8>{{0.9, 0.05, 0.0003, -0.0002, 0.0005, 1.25, 0.25, 0.01}, 1.1},
                                        ExampleShape<8>{{-0.2, 0.3, 0.001, -0.001, 0.02, 0.1, 0.25, 0.03}, 0.8},
                                        ExampleShape<8>{{4.1, 1.1, -0.0002, 0.0001, 0.03, 4.5, 2.4, 0.3}, 1.2}};
  static constexpr std::array kForeignNames{
      ForeignName{"opencv", "rational_polynomial"}, ForeignName{"ros", "rational_polynomial"},
      ForeignName{"mrcal", "LENSMODEL_OPENCV8"}, ForeignName{"colmap", "FULL_OPENCV"}};
};
static_assert(CameraModel<Rational>);

}  // namespace raybundle
