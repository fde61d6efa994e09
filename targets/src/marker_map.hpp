// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace raybundle {

/// Where a board point comes to lie in the image, and how the board is stretched there.
struct LocalPrediction {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Matrix2d pixel_from_board = Eigen::Matrix2d::Zero();  ///< [px/m], first derivative at the point
};

/// Board-to-image map known from scattered points: at each place a homography through the nearest ones. Needs no camera
/// model, and follows any lens as far as its neighbours reach.
class MarkerMap {
 public:
  /// @param weight  1 for a refined point, less for a rough one
  void add(const Eigen::Vector2d& x_in_board, const Eigen::Vector2d& pixel, double weight);

  /// Distance to the nearest known point [m]; infinite when there is none.
  double distance(const Eigen::Vector2d& x_in_board) const;

  /// Nothing when there are fewer than four points, when they are collinear, or when the nearest one is further away
  /// than `reach_m`.
  std::optional<LocalPrediction> predict(const Eigen::Vector2d& x_in_board, double reach_m) const;

 private:
  struct Point {
    Eigen::Vector2d x_in_board;
    Eigen::Vector2d pixel;
    double weight;
  };
  std::vector<Point> points_;
};

/// Homography through weighted points, in the least squares sense, as the map at the origin of the first coordinates.
/// Nothing when fewer than four points are given or when they are nearly collinear.
std::optional<LocalPrediction> map_at_origin(const std::vector<Eigen::Vector2d>& from,
                                             const std::vector<Eigen::Vector2d>& to,
                                             const std::vector<double>& weights);

}  // namespace raybundle
