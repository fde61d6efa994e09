// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "board_scene.hpp"
#include "print_coverage.hpp"
#include "raybundle/synthetic/camera_rays.hpp"
#include "raybundle/synthetic/lens_blur.hpp"

namespace raybundle {

/// What a pixel's cells show, row by row.
struct PixelCells {
  float covered[kCellsPerPixel * kCellsPerPixel];  ///< share of the cell that is board; the rest is behind it
  float albedo[kCellsPerPixel * kCellsPerPixel];   ///< times the share
};

/// The board as a camera sees it in one pose.
class SeenBoard {
 public:
  SeenBoard(const SimulatedBoard& board, const BoardScene& scene, const PrintCoverage& print, const CameraRays& rays,
            const Rigid3& target_from_camera);

  const Eigen::Vector3d& eye() const { return target_from_camera_.translation; }  ///< in the target's frame

  /// Direction in the target's frame of a place in a pixel.
  Eigen::Vector3d direction(int x, int y, double u, double v) const { return rotation_ * rays_->at(x, y, u, v); }

  int margin() const { return rays_->margin(); }
  bool lit(int x, int y) const { return rays_->lit(x, y); }

  /// Whether any of the pixel may be board.
  bool meets(int x, int y) const;

  /// @return  false when the pixel shows no board: cells are not touched then
  bool cells(int x, int y, PixelCells& cells) const;

  /// 1 where the camera is on the side of positive z of the board, else -1.
  double side(const Eigen::Vector2d& place) const;

  /// A place on the board that the pixel shows; of one at the edge of the board it may lie beside the sheet.
  Eigen::Vector2d some_place(int x, int y) const;

 private:
  std::optional<Quad> quad(int x, int y) const;
  void cell(const Quad& quad, bool printed, float& covered, float& albedo) const;

  const SimulatedBoard* board_;
  const BoardScene* scene_;
  const PrintCoverage* print_;
  const CameraRays* rays_;
  Rigid3 target_from_camera_;
  Eigen::Matrix3d rotation_;
  std::vector<Eigen::Vector2d> places_;  ///< of the corners of pixels; NaN where there is no board
};

}  // namespace raybundle
