// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/synthetic/simulate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "board_poses.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/synthetic/random.hpp"
#include "view_geometry.hpp"

namespace raybundle {
namespace {

constexpr double kStatedSigma_px = 0.1;     // of observations without noise
constexpr double kBrightnessSpread = 0.05;  // speckle and shot noise, summed over a spot
constexpr double kOutstandingPower = 1.25;  // of order zero over the others, from where on it can be told
constexpr double kFarAway_m = 0.7;          // where a beam that was never hit has its point

// A view, noisy and exact.
struct ViewPair {
  TargetView measured, exact;
};

class Observer {
 public:
  Observer(const SimulatedRig& rig, const SimulateOptions& options, const std::vector<EmittedBeam>& beams)
      : rig_(rig),
        options_(options),
        beams_(beams),
        surface_(rig.board.target),
        points_(points_on_surface(rig.board.target, rig.board.shape)) {}

  const BoardSurface& surface() const { return surface_; }

  // Nothing when the camera sees too little of the board.
  std::optional<ViewPair> view(int camera, int frame, const Rigid3& rig_from_target) const {
    const PlacedBoard board(rig_.board, surface_, rig_from_target);
    const auto stream = static_cast<std::uint64_t>(frame) * rig_.cameras.size() + static_cast<std::uint64_t>(camera);
    Random random(options_.seed, 2 * stream + 1);
    ViewPair pair{{camera, frame, 0, {}}, {camera, frame, 0, {}}};
    add_corners(board, random, pair);
    if (static_cast<int>(pair.measured.observations.size()) < options_.min_corners) return std::nullopt;
    add_dots(board, random, pair);
    return pair;
  }

 private:
  Eigen::Vector2d moved(const Eigen::Vector2d& pixel, double sigma_px, Random& random) const {
    const double x = random.normal(), y = random.normal();
    return pixel + sigma_px * Eigen::Vector2d(x, y);
  }

  void add_corners(const PlacedBoard& board, Random& random, ViewPair& pair) const {
    const double sigma = options_.corner_sigma_px > 0 ? options_.corner_sigma_px : kStatedSigma_px;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const auto pixel = board.seen_at(rig_.cameras[pair.exact.camera], points_[i]);
      if (!pixel) continue;
      const int id = rig_.board.target.points[i].id;
      pair.exact.observations.push_back({*pixel, sigma, id});
      pair.measured.observations.push_back({moved(*pixel, options_.corner_sigma_px, random), sigma, id});
    }
  }

  // Grey values above the background, summed: what the spot's light would be, over that which fills a pixel's range.
  double brightness(const PlacedBoard& board, const SimulatedCamera& camera, const Eigen::Vector3d& place,
                    double power_W, Random& random) const {
    const SimulatedBoard& paper = rig_.board;
    const double albedo = is_ink(paper.print, place.head<2>()) ? paper.ink_albedo : paper.paper_albedo;
    const double range = std::exp2(camera.sensor.bits) - 1.0;
    const double full_W = camera.sensor.white_W_m2 / camera.sensor.exposure * board.pixel_area_m2(camera, place);
    return range * albedo * power_W / full_W * std::exp(kBrightnessSpread * random.normal());
  }

  void add_dot(const PlacedBoard& board, const Eigen::Vector3d& place, double power_W, int label, Random& random,
               ViewPair& pair) const {
    const SimulatedCamera& camera = rig_.cameras[pair.exact.camera];
    const auto pixel = board.seen_at(camera, place);
    if (!pixel) return;
    const double sigma = options_.dot_sigma_px > 0 ? options_.dot_sigma_px : kStatedSigma_px;
    Dot dot{*pixel, sigma * sigma * Eigen::Matrix2d::Identity(), label,
            brightness(board, camera, place, power_W, random)};
    const Eigen::Vector2d measured = moved(*pixel, options_.dot_sigma_px, random);
    if (label != kUnlabelled && random.chance(options_.missed)) return;
    pair.exact.dots.push_back(dot);
    dot.pixel = measured;
    if (!options_.labelled) dot.beam = kUnlabelled;
    pair.measured.dots.push_back(dot);
  }

  void add_dots(const PlacedBoard& board, Random& random, ViewPair& pair) const {
    if (!rig_.emitter) return;
    for (const EmittedBeam& beam : beams_) {
      const auto place = board.spot(beam.line);
      const int label = beam.labelled() ? rig_.emitter->grid.index(beam.row, beam.column) : kUnlabelled;
      if (place) add_dot(board, *place, beam.power_W, label, random, pair);
    }
    const BoardPrint::Box& sheet = rig_.board.print.sheet;
    const auto true_dots = pair.measured.dots.size();
    for (std::size_t i = 0; i < true_dots; ++i) {
      if (!random.chance(options_.spurious)) continue;
      const double x = random.uniform(sheet.low.x(), sheet.high.x()), y = random.uniform(sheet.low.y(), sheet.high.y());
      const Eigen::Vector3d place(x, y, surface_.height(x, y, rig_.board.shape));
      add_dot(board, place, rig_.emitter->beam_power_W, kUnlabelled, random, pair);
    }
    if (!options_.labelled) shuffle(random, pair);
  }

  // Fisher and Yates; both in the same order.
  static void shuffle(Random& random, ViewPair& pair) {
    for (std::size_t i = pair.measured.dots.size(); i > 1; --i) {
      const int k = random.below(static_cast<int>(i));
      std::swap(pair.measured.dots[i - 1], pair.measured.dots[k]);
      std::swap(pair.exact.dots[i - 1], pair.exact.dots[k]);
    }
  }

  const SimulatedRig& rig_;
  const SimulateOptions& options_;
  const std::vector<EmittedBeam>& beams_;
  BoardSurface surface_;
  std::vector<Eigen::Vector3d> points_;
};

ProblemLaser problem_laser(const Emitter& emitter) {
  ProblemLaser laser{emitter.grid};
  for (const auto& [row, column] : emitter.missing) laser.missing.push_back(emitter.grid.index(row, column));
  const int row = static_cast<int>(emitter.zero_order_row), column = static_cast<int>(emitter.zero_order_column);
  const bool in_grid = row == emitter.zero_order_row && column == emitter.zero_order_column && row >= 0 &&
                       row < emitter.grid.rows && column >= 0 && column < emitter.grid.columns;
  if (in_grid && emitter.zero_order_power >= kOutstandingPower) laser.brightest = emitter.grid.index(row, column);
  if (in_grid && emitter.zero_order_power == 0.0) laser.missing.push_back(emitter.grid.index(row, column));
  return laser;
}

CalibrationProblem empty_problem(const SimulatedRig& rig, int frames) {
  CalibrationProblem problem;
  for (const SimulatedCamera& camera : rig.cameras) {
    problem.cameras.push_back({camera.name, camera.camera.model, camera.camera.size, std::nullopt, std::nullopt});
  }
  problem.targets.push_back(rig.board.target);
  for (int frame = 0; frame < frames; ++frame) problem.frames.push_back(std::to_string(frame));
  if (rig.emitter) problem.laser = problem_laser(*rig.emitter);
  return problem;
}

// The true beams with their hits; points of lines are put amid the hits, as in a calibration.
LaserPattern true_pattern(const Emitter& emitter, const Simulation& simulation, const SimulatedBoard& board,
                          const BoardSurface& surface) {
  LaserPattern pattern{emitter.grid, {}, std::nullopt, emitter.zero_order_row, emitter.zero_order_column};
  for (const EmittedBeam& emitted : simulation.beams) {
    if (!emitted.labelled()) continue;
    LaserBeam beam{emitted.row, emitted.column, emitted.line};
    beam.line.point = emitted.line.at(-emitted.line.point.dot(emitted.line.direction));  // nearest to the origin
    const int label = emitter.grid.index(beam.row, beam.column);
    double sum = 0.0, nearest = std::numeric_limits<double>::infinity(), farthest = 0.0;
    for (const TargetView& view : simulation.exact.views) {
      if (std::ranges::find(view.dots, label, &Dot::beam) == view.dots.end()) continue;
      const PlacedBoard placed(board, surface, simulation.poses[view.frame].rig_from_target);
      const Eigen::Vector3d hit = placed.rig_from_target() * *placed.spot(emitted.line);
      const double along = (hit - beam.line.point).dot(beam.line.direction);
      sum += along;
      nearest = std::min(nearest, along);
      farthest = std::max(farthest, along);
      ++beam.hits;
    }
    beam.nearest_hit_m = beam.hits > 0 ? nearest : 0.0;
    beam.farthest_hit_m = farthest;
    beam.line.point = beam.line.at(beam.hits > 0 ? sum / beam.hits : kFarAway_m);
    pattern.beams.push_back(beam);
  }
  return pattern;
}

void check(const SimulatedRig& rig, const SimulateOptions& options) {
  const auto refuse = [](const std::string& message) { throw Error(ErrorKind::kBadInput, message); };
  const auto share = [](double value) { return value >= 0 && value <= 1; };
  if (rig.cameras.empty() || rig.board.target.points.size() < 4) refuse("a rig needs a camera and a board");
  if (options.frames < 1) refuse("frames is " + std::to_string(options.frames) + ", but must be at least 1");
  if (!(options.corner_sigma_px >= 0 && options.dot_sigma_px >= 0)) refuse("sigmas must not be negative");
  if (!share(options.missed) || !share(options.spurious)) refuse("shares of missed and spurious dots are 0 to 1");
}

}  // namespace

Simulation simulate(const SimulatedRig& rig, const SimulateOptions& options) {
  check(rig, options);
  Simulation simulation;
  if (rig.emitter) simulation.beams = beams_of(warmer(*rig.emitter, options.warmer_K));
  const Observer observer(rig, options, simulation.beams);
  simulation.problem = simulation.exact = empty_problem(rig, options.frames);
  const std::vector<EmittedBeam> cold = rig.emitter ? beams_of(*rig.emitter) : std::vector<EmittedBeam>{};
  const std::vector<Rigid3> poses = random_board_poses(rig, observer.surface(), cold, options.frames, options.seed);
  for (int frame = 0; frame < options.frames; ++frame) {
    simulation.poses.push_back({frame, 0, poses[frame]});
    for (int camera = 0; camera < static_cast<int>(rig.cameras.size()); ++camera) {
      const auto pair = observer.view(camera, frame, poses[frame]);
      if (!pair) continue;
      simulation.problem.views.push_back(pair->measured);
      simulation.exact.views.push_back(pair->exact);
    }
  }
  for (const SimulatedCamera& camera : rig.cameras) {
    simulation.truth.cameras.push_back({camera.name, camera.camera, camera.camera_from_rig});
  }
  simulation.truth.targets.push_back({rig.board.target, rig.board.shape});
  if (rig.emitter) simulation.truth.laser = true_pattern(*rig.emitter, simulation, rig.board, observer.surface());
  raybundle::check(simulation.problem);
  return simulation;
}

}  // namespace raybundle
