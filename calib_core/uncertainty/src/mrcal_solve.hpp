// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "projection_difference.hpp"
#include "raybundle/scene/calibration.hpp"

namespace raybundle {

/// A lattice whose nodes, row by row, hold the points of a board; some nodes may hold none.
struct GridOfPoints {
  int rows = 0;
  int columns = 0;
  double spacing_m = 0.0;
  Eigen::Vector2d origin_m = Eigen::Vector2d::Zero();  ///< first node, in the board's frame
  std::vector<int> node_of_point = {};                 ///< aligned with Target::points
};

struct MrcalCorner {
  int node = 0;
  Eigen::Vector2d pixel;
  double weight = 1.0;        ///< of the residual
  Eigen::Vector2d predicted;  ///< where the first opinion projects it
};

struct MrcalView {
  int camera = 0;
  int pose = 0;
  std::vector<MrcalCorner> corners;
};

struct MrcalCamera {
  ImageSize size;
  Eigen::VectorXd parameters;  ///< of the problem's lens model: fx fy cx cy, then its own
  Rigid3 camera_from_rig;
};

/// What mrcal's optimiser is given. Cameras and poses are where it starts. Of splined models the first four parameters
/// stay, for the knots can do all that they do, and mrcal's regularisation holds the knots that no corner sees.
struct MrcalProblem {
  std::string lens_model;  ///< LENSMODEL_...
  GridOfPoints grid;
  std::vector<MrcalCamera> cameras = {};  ///< the first one's frame is the rig frame
  std::vector<Rigid3> rig_from_target = {};
  std::vector<MrcalView> views = {};
  bool with_shape = false;
};

struct MrcalAnswer {
  std::vector<MrcalCamera> cameras;
  std::vector<Rigid3> rig_from_target;
  double rms_px = 0.0;  ///< unweighted; root of the mean squared distance
};

/// Whether this build can ask mrcal.
bool mrcal_available();

/// Nothing when the optimiser fails.
std::optional<MrcalAnswer> solve_with_mrcal(const MrcalProblem& problem);

/// How many parameters a lens model of mrcal has.
int mrcal_parameter_count(const std::string& lens_model);

/// Where a lens of mrcal sees a ray.
SeenRay mrcal_pixel(const std::string& lens_model, const Eigen::VectorXd& parameters, const Eigen::Vector3d& ray);

}  // namespace raybundle
