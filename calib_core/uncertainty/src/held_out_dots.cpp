// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/held_out_dots.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "raybundle/scene/board_surface.hpp"

namespace raybundle {
namespace {

constexpr double kRunnerUp = 2.0;  // times farther away the second beam must be

struct Prediction {
  int beam = 0;          // LaserGrid::index
  const Line3* line;     // in the rig frame
  double range_m = 0.0;  // of the board along it
  Eigen::Vector2d pixel;
};

/// The board as the calibration knows it, else as it is.
CalibratedTarget board_of(const Calibration& calibration, const Target& target) {
  const auto known = std::ranges::find_if(calibration.targets,
                                          [&](const CalibratedTarget& t) { return t.target.name == target.name; });
  return known != calibration.targets.end() ? *known : CalibratedTarget{target, {}};
}

/// Where the beams meet a board, for those that the camera sees there.
std::vector<Prediction> predictions(const LaserPattern& pattern, const RigCamera& camera, const BoardSurface& surface,
                                    const BoardShape& shape, const Rigid3& rig_from_target) {
  const Rigid3 target_from_rig = rig_from_target.inverse();
  std::vector<Prediction> result;
  for (const LaserBeam& beam : pattern.beams) {
    const auto crossing = surface.crossing(target_from_rig * beam.line, shape);
    if (!crossing) continue;
    const Eigen::Vector3d in_rig = rig_from_target * *crossing;
    const auto pixel = pixel_from_ray(camera.camera, camera.camera_from_rig * in_rig);
    if (!pixel) continue;
    result.push_back({pattern.grid.index(beam.row, beam.column), &beam.line,
                      beam.line.direction.dot(in_rig - beam.line.point), *pixel});
  }
  return result;
}

/// The prediction that a pixel belongs to without doubt.
const Prediction* nearest(const std::vector<Prediction>& all, const Eigen::Vector2d& pixel, double tolerance_px) {
  const Prediction* best = nullptr;
  double first = std::numeric_limits<double>::infinity(), second = first;
  for (const Prediction& prediction : all) {
    const double distance = (prediction.pixel - pixel).norm();
    if (distance < first) {
      second = first;
      first = distance;
      best = &prediction;
    } else {
      second = std::min(second, distance);
    }
  }
  return first <= tolerance_px && second > kRunnerUp * first ? best : nullptr;
}

}  // namespace

std::optional<Eigen::Vector3d> point_on_beam(const RigCamera& camera, const Line3& line, const Eigen::Vector2d& pixel,
                                             double start_m) {
  constexpr double kStep_m = 1e-5;  // for the derivative along the beam
  double range = start_m;
  for (int iteration = 0; iteration < 20; ++iteration) {
    const auto here = pixel_from_ray(camera.camera, camera.camera_from_rig * line.at(range));
    const auto there = pixel_from_ray(camera.camera, camera.camera_from_rig * line.at(range + kStep_m));
    if (!here || !there) return std::nullopt;
    const Eigen::Vector2d slope = (*there - *here) / kStep_m;
    if (!(slope.squaredNorm() > 1e-12)) return std::nullopt;
    const double step = slope.dot(pixel - *here) / slope.squaredNorm();
    range += step;
    if (std::abs(step) < 1e-9) return line.at(range);
  }
  return std::nullopt;
}

std::vector<HeldOutDot> explain_dots(const Calibration& calibration, const CalibrationProblem& problem,
                                     const std::vector<std::optional<Rigid3>>& rig_from_target, double tolerance_px) {
  std::vector<HeldOutDot> explained;
  if (!calibration.laser) return explained;
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    const TargetView& view = problem.views[v];
    if (!rig_from_target[v] || view.dots.empty()) continue;
    const RigCamera& camera = camera_named(calibration, problem.cameras[view.camera].name);
    const CalibratedTarget board = board_of(calibration, problem.targets[view.target]);
    if (!board.target.flat()) continue;
    const BoardShape& shape = board.shape;
    const BoardSurface surface(board.target);
    const std::vector<Prediction> all = predictions(*calibration.laser, camera, surface, shape, *rig_from_target[v]);
    const bool faces = (camera.camera_from_rig * *rig_from_target[v]).inverse().translation.z() > 0.0;
    for (std::size_t i = 0; i < view.dots.size(); ++i) {
      const Prediction* prediction = nearest(all, view.dots[i].pixel, tolerance_px);
      if (prediction == nullptr) continue;
      const auto in_rig = point_on_beam(camera, *prediction->line, view.dots[i].pixel, prediction->range_m);
      if (!in_rig) continue;
      const Eigen::Vector3d on_board = rig_from_target[v]->inverse() * *in_rig;
      const double height = on_board.z() - surface.height(on_board.x(), on_board.y(), shape);
      explained.push_back({static_cast<int>(v), static_cast<int>(i), prediction->beam,
                           view.dots[i].pixel - prediction->pixel, (camera.camera_from_rig * *in_rig).z(),
                           faces ? height : -height});
    }
  }
  return explained;
}

std::vector<DotsOnBoard> dots_on_boards(const Calibration& calibration, const CalibrationProblem& problem,
                                        const std::vector<std::optional<Rigid3>>& rig_from_target) {
  std::vector<DotsOnBoard> on_boards(problem.views.size());
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    const TargetView& view = problem.views[v];
    if (!rig_from_target[v] || view.dots.empty() || !calibration.laser) continue;
    const RigCamera& camera = camera_named(calibration, problem.cameras[view.camera].name);
    const CalibratedTarget board = board_of(calibration, problem.targets[view.target]);
    if (!board.target.flat()) continue;
    const BoardSurface surface(board.target);
    const Rigid3 rig_from_camera = camera.camera_from_rig.inverse(), target_from_rig = rig_from_target[v]->inverse();
    const auto covered = [&](const Line3& line_in_rig) {
      const auto crossing = surface.crossing(target_from_rig * line_in_rig, board.shape);
      return crossing && surface.covers(*crossing);
    };
    for (const Dot& dot : view.dots) {
      const auto ray = ray_from_pixel(camera.camera, dot.pixel);
      on_boards[v].dots += ray && covered(rig_from_camera * Line3{Eigen::Vector3d::Zero(), *ray});
    }
    for (const Prediction& beam : predictions(*calibration.laser, camera, surface, board.shape, *rig_from_target[v])) {
      on_boards[v].beams += camera.camera.size.contains(beam.pixel) && covered(*beam.line);
    }
  }
  return on_boards;
}

}  // namespace raybundle
