// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "raybundle/camera/camera.hpp"
#include "raybundle/device/image_view.hpp"
#include "raybundle/stereo/matcher.hpp"
#include "raybundle/stereo/rectification.hpp"

namespace raybundle {

/// A laser dot with a measured distance, where the left rectified image shows it.
struct AnchorDot {
  double u_px = 0.0;
  double v_px = 0.0;
  double disparity_px = 0.0;  ///< of its distance, disparity_from_distance()
  double sigma_px = 0.0;      ///< of the disparity, > 0
};

/// The dot of a measured point; nothing when the rectified image does not show it, or it lies behind the cameras.
///
/// @param x_in_left      [m] in the left camera's frame
/// @param covariance_m2  of it
std::optional<AnchorDot> anchor_dot(const Rectification& pair, const Eigen::Vector3d& x_in_left,
                                    const Eigen::Matrix3d& covariance_m2);

struct DotFusionOptions {
  double reach_px = 48.0;          ///< farthest dot that tells anything about a pixel
  double like_grey = 20.0;         ///< most difference of grey values of a pixel and a dot's surroundings
  double ring_px = 4.0;            ///< radius at which a dot's surroundings are, outside of its light
  double most_slope = 0.3;         ///< of a surface's disparity [px/px]: what is steeper is a step in depth
  double bend = 0.0005;            ///< standard deviation of a surface's second derivative [1/px]
  double gate_sigmas = 3.0;        ///< dots that disagree more are not of one surface
  double contradict_sigmas = 6.0;  ///< a match that disagrees more with the dot that lies on it is taken out
  int most_dots = 1024;            ///< what there is memory for; dots beyond it are left out
};

/// Where a disparity comes from.
enum class DisparitySource : std::uint8_t {
  kNone = 0,      ///< there is none, for the reason that the matcher gave
  kMatched,       ///< the matcher's
  kDots,          ///< of the laser dots around the pixel
  kContradicted,  ///< there is none: a dot contradicts the match
};

struct FusedView {
  ImageView<const float> disparity_px;   ///< 0 where there is none
  ImageView<const float> sigma_px;       ///< 0 where there is none
  ImageView<const std::uint8_t> source;  ///< DisparitySource of each pixel
  int filled = 0;                        ///< pixels that have their disparity of dots
  int contradicted = 0;                  ///< matches that were taken out
};

/// Fills with laser dots what the matcher left empty.
///
/// Through each dot and its nearest neighbours of like surroundings goes the plane that most of them agree with, of
/// those the least steep. A pixel without a match takes the planes of the nearest dots in each quadrant about it,
/// weighted by their variances, if they are in three quadrants at least, so that hardly anything is extrapolated, if all are of
/// the pixel's grey, and if the planes agree. Sigma grows with the distance from the dots, and is not made smaller by
/// their number, because planes share dots. Without dots every disparity is the matcher's, bit for bit.
///
/// All memory is taken by the constructor; fuse() takes none and throws nothing.
class DotFusion {
 public:
  /// @param calibration_sigma_px  of the disparity of each pixel, by which all matches there may be off; empty: none
  /// @throws Error(kBadInput) for options or a size that cannot be
  explicit DotFusion(ImageSize size, const DotFusionOptions& options = {},
                     std::span<const float> calibration_sigma_px = {});

  /// @param left   rectified
  /// @param dense  of the same size, Matcher's
  /// @param dots   those outside of the image or without a positive sigma are left out
  /// @return       valid until the next call
  FusedView fuse(GreyView left, const DisparityView& dense, std::span<const AnchorDot> dots);

 private:
  struct Plane {
    AnchorDot dot;
    int grey = 0;                                            // of the dot's surroundings
    int next = -1;                                           // dot of the same cell
    bool agreed = false;                                     // with other dots: only then it may be used
    Eigen::Vector3d disparity_px = Eigen::Vector3d::Zero();  // at the dot, and for each px to the right and down
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();

    double at(double du, double dv) const { return disparity_px.dot(Eigen::Vector3d(1.0, du, dv)); }
    double variance(double du, double dv) const {
      const Eigen::Vector3d row(1.0, du, dv);
      return row.dot(covariance * row);
    }
  };

  void place(GreyView left, std::span<const AnchorDot> dots);
  void fit(Plane& plane);
  bool fill(int u, int v, int grey, float& disparity_px, float& sigma_px) const;
  int contradict(const Plane& plane);
  template <typename Visit>
  void near(double u, double v, Visit visit) const;

  ImageSize size_;
  DotFusionOptions options_;
  int columns_, rows_;       // of cells with a side of the reach
  std::vector<int> cells_;   // the first dot of each
  std::vector<Plane> dots_;  // of capacity most_dots
  std::vector<float> calibration_sigma_px_;
  std::vector<float> disparity_px_, sigma_px_;
  std::vector<std::uint8_t> source_;
};

}  // namespace raybundle
