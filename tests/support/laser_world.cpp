// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "laser_world.hpp"

#include <algorithm>
#include <random>

#include "raybundle/scene/board_surface.hpp"

namespace raybundle::testing {
namespace {

constexpr double kBoardMargin_m = 0.02;  // of white around the points, where dots are seen too

std::vector<std::optional<Line3>> true_lines(const LaserOptions& options, std::mt19937& random) {
  std::normal_distribution<double> normal;
  Grating grating;
  grating.rig_from_projector.rotation = Eigen::AngleAxisd(options.turn_rad, Eigen::Vector3d::UnitZ());
  grating.rig_from_projector.translation << options.gap_m, 0.01, 0.0;
  grating.column_pitch = 1.2 / options.grid.columns;
  grating.row_pitch = 1.0 / options.grid.rows;
  grating.k1 = 0.15;
  grating.shift_m = -0.003;
  std::vector<std::optional<Line3>> lines;
  for (int beam = 0; beam < options.grid.size(); ++beam) {
    const double m = options.grid.column(beam) - 0.5 * (options.grid.columns - 1);
    const double n = options.grid.row(beam) - 0.5 * (options.grid.rows - 1);
    lines.push_back(beam_of_order(grating, m, n));
    Eigen::Vector4d deviation =
        options.offset_rad * Eigen::Vector4d(normal(random), normal(random), normal(random), normal(random));
    deviation.head<2>() *= 0.3;  // [m] for each rad: where a beam crosses the lens
    if (lines.back()) lines.back() = perturbed(*lines.back(), deviation);
    if (std::ranges::count(options.missing, beam) > 0) lines.back().reset();
  }
  return lines;
}

// Where a camera sees the dot of a line on a board; nothing when it does not.
std::optional<Eigen::Vector2d> dot_pixel(const SyntheticWorld& world, const TargetView& view,
                                         const Rigid3& rig_from_target, const BoardSurface& surface,
                                         const Line3& line) {
  const Rigid3 target_from_rig = rig_from_target.inverse();
  const Line3 in_target = target_from_rig * line;
  const std::optional<Eigen::Vector3d> x = surface.crossing(in_target, world.shapes[view.target]);
  if (!x || !surface.covers(*x, kBoardMargin_m) || (*x - in_target.point).dot(in_target.direction) < 0) return {};
  const Camera& camera = world.cameras[view.camera];
  const Eigen::Vector3d x_in_camera = world.camera_from_rig[view.camera] * (rig_from_target * *x);
  const std::optional<Eigen::Vector2d> pixel = pixel_from_ray(camera, x_in_camera);
  const bool inside = pixel && (pixel->array() >= 0).all() && pixel->x() <= camera.size.width - 1 &&
                      pixel->y() <= camera.size.height - 1;
  return inside ? pixel : std::nullopt;
}

}  // namespace

LaserTruth add_laser(SyntheticWorld& world, const LaserOptions& options) {
  std::mt19937 random(options.seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  LaserTruth truth{.lines = true_lines(options, random), .beam_of_dot = {}};
  world.problem.laser = ProblemLaser{.grid = options.grid};
  const int middle = options.grid.index(options.grid.rows / 2, options.grid.columns / 2);
  const double sigma = options.noise_px > 0 ? options.noise_px : 0.1;
  for (std::size_t v = 0; v < world.problem.views.size(); ++v) {
    TargetView& view = world.problem.views[v];
    const BoardSurface surface(world.problem.targets[view.target]);
    const Rigid3& rig_from_target = world.poses[world.pose_of_view[v]].rig_from_target;
    std::vector<std::pair<Dot, int>> dots;
    for (int beam = 0; beam < options.grid.size(); ++beam) {
      if (!truth.lines[beam]) continue;
      const auto exact = dot_pixel(world, view, rig_from_target, surface, *truth.lines[beam]);
      if (!exact || uniform(random) < options.missed_fraction) continue;
      Dot dot{.pixel = *exact + options.noise_px * Eigen::Vector2d(normal(random), normal(random)),
              .covariance_px2 = sigma * sigma * Eigen::Matrix2d::Identity(),
              .beam = options.labelled ? beam : kUnlabelled,
              .brightness = (beam == middle ? options.brightest_factor : 1.0) * (0.8 + 0.2 * uniform(random))};
      dots.emplace_back(dot, beam);
      if (uniform(random) < options.spurious_fraction) {
        dot.pixel << uniform(random) * world.cameras[view.camera].size.width,
            uniform(random) * world.cameras[view.camera].size.height;
        dot.beam = kUnlabelled;
        dots.emplace_back(dot, kUnlabelled);
      }
    }
    std::ranges::shuffle(dots, random);
    truth.beam_of_dot.emplace_back();
    for (const auto& [dot, beam] : dots) {
      view.dots.push_back(dot);
      truth.beam_of_dot.back().push_back(beam);
    }
  }
  return truth;
}

CalibrationProblem with_noise(CalibrationProblem problem, double sigma_px, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, sigma_px);
  const auto disturb = [&](Eigen::Vector2d& pixel) {
    pixel.x() += noise(random);
    pixel.y() += noise(random);
  };
  for (TargetView& view : problem.views) {
    for (Observation& observation : view.observations) disturb(observation.pixel);
    for (Dot& dot : view.dots) disturb(dot.pixel);
  }
  return problem;
}

SyntheticOptions laser_rig_options(int frames, unsigned seed) {
  SyntheticOptions options;
  options.cameras[0].size = {640, 480};
  options.cameras[0].focal_px = 282.0;
  options.columns = 11;
  options.rows = 8;
  options.square_m = 0.06;
  options.frames = frames;
  options.min_distance_m = 0.3;
  options.max_distance_m = 1.2;
  options.max_tilt_rad = 0.7;
  options.max_off_axis_rad = 0.6;
  options.seed = seed;
  return options;
}

}  // namespace raybundle::testing
