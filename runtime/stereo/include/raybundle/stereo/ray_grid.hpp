// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "raybundle/stereo/rectified_camera.hpp"
#include "raybundle/stereo/stereo.hpp"

namespace raybundle {

struct RayGridOptions {
  double rays_per_rad = 0.0;  ///< along and across the baseline
  double field_x_rad = 0.0;   ///< of view that is kept along the baseline; what lies beyond it is left out
  double field_y_rad = 0.0;   ///< the same across it
  double alike = 0.2;         ///< pixels whose density differs by less than this share stay as they are
};

/// The points of a pair as a camera of few pixels would have them: rays that are equally dense in angle, whatever the
/// images' size and projection. What was learnt or tuned with so many points can then be asked of others.
///
/// Of the pixels of a ray the point of median range is kept, where half of them have one, so that neither rims nor
/// single wrong matches decide. All memory is taken by the constructor; thin() takes none and throws nothing.
class RayGrid {
 public:
  /// @throws Error(kBadInput) when the camera is less dense than the grid
  RayGrid(const RectifiedCamera& camera, const RayGridOptions& options);

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  int rays() const { return columns_ * rows_; }
  double pixels() const { return pixels_each_way_; }  ///< of a ray, each way; 1 where pixels stay as they are

  /// @param points  of images of the camera's size
  /// @return        one for each ray, row by row; sigma_m is 0 where there is none. Valid until the next call
  std::span<const StereoPoint> thin(ImageView<const StereoPoint> points);

 private:
  using Place = std::pair<float, int>;  // squared range, pixel

  double pixels_each_way_ = 1.0;
  int width_ = 0, columns_ = 0, rows_ = 0;
  std::vector<int> pixels_;  // of all rays, those of one ray together
  std::vector<int> first_;   // of each ray in pixels_, and behind the last one
  std::vector<Place> of_ray_;
  std::vector<StereoPoint> thinned_;
};

}  // namespace raybundle
