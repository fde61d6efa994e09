// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "raybundle/scene/problem.hpp"
#include "raybundle/scene/result.hpp"

namespace raybundle::testing {

/// A camera of a synthetic rig.
struct SyntheticCamera {
  std::string model = "kannala_brandt";
  ImageSize size{1280, 960};
  double focal_px = 380.0;
  std::vector<double> shape;                    ///< empty: the model's first example
  Eigen::Vector2d centre_offset_px{7.0, -5.0};  ///< principal point minus image centre
  double aspect = 1.0;                          ///< fy / fx
  Rigid3 camera_from_rig;                       ///< of the first camera: the identity
};

struct SyntheticOptions {
  std::vector<SyntheticCamera> cameras{SyntheticCamera{}};
  int columns = 9;  ///< of the one flat board, which is a grid of points
  int rows = 7;
  double square_m = 0.04;
  int boards = 1;
  int frames = 20;
  double noise_px = 0.0;
  BoardShape shape;
  double min_distance_m = 0.3;  ///< of the board's centre from the rig
  double max_distance_m = 0.8;
  double max_tilt_rad = 0.8;      ///< of the board against the line of sight
  double max_off_axis_rad = 0.9;  ///< of the board's centre, in the first camera or a random one
  int min_points = 8;             ///< views with fewer visible points are not made
  double outlier_fraction = 0.0;  ///< of the corners, moved by 5 to 50 px
  unsigned seed = 1;
};

/// Two cameras side by side, 0.1 m apart.
SyntheticOptions stereo_head();

/// A problem whose answer is known.
struct SyntheticWorld {
  CalibrationProblem problem;
  std::vector<Camera> cameras;
  std::vector<Rigid3> camera_from_rig;
  std::vector<BoardPose> poses;
  std::vector<BoardShape> shapes;           ///< aligned with problem.targets
  std::vector<int> pose_of_view;            ///< aligned with problem.views
  std::vector<std::vector<bool>> outliers;  ///< aligned with problem.views and their observations
};

/// A flat board of columns × rows points, ids row by row.
Target grid_target(const std::string& name, int columns, int rows, double square_m);

/// Boards in random poses, each aimed at one of the cameras in turn; points within the image and the model's field are
/// observed with Gaussian noise. The same options give the same world.
SyntheticWorld synthetic_world(const SyntheticOptions& options);

}  // namespace raybundle::testing
