// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Laser beams calibrated with their camera from simulated observations of 0.1 px, labels and all, against the truth:
// depth bias at 1 m, held-out planes, wrong labels, convergence, and whether the beams' scatter is what their
// covariance says. Each line is one grid and number of views over all seeds: median (worst). usage: prove_laser [seeds,
// default 20] [grid or all] [views or 0 for 20 and 60]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <numeric>
#include <string>
#include <vector>

#include "laser_figures.hpp"
#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/geometry/quantile.hpp"
#include "raybundle/synthetic/simulate.hpp"
#include "raybundle/uncertainty/held_out_dots.hpp"
#include "raybundle/uncertainty/wavelength.hpp"

namespace {

using namespace raybundle;
using namespace raybundle::bench;

/// How far the points of held-out boards lie off them at a depth.
struct PlaneFigures {
  double plane_mm = INFINITY;  // root mean square over a board's points, median over the boards
  double dots_mm = INFINITY;   // root mean square over the points of all boards: oblique and outermost ones weigh most
};

/// Of a seed; infinitely bad unless it gives beams.
struct Figures {
  double depth_bias_mm = INFINITY;      // of exact dots at 1 m: median over the beams of the absolute error
  PlaneFigures half, one;               // of held-out boards at 0.5 m and at 1 m
  PlaneFigures floor_half, floor_one;   // the same of the true calibration: what the dots' own noise costs
  double warm_mm = INFINITY;            // depth bias at 1 m when the laser is 10 K warmer
  double retuned_mm = INFINITY;         // and with the wavelength that five frames show
  double wavelength_sigmas = INFINITY;  // error of that wavelength
  int wrong_labels = 0;
  int unlabelled = 0;
  bool converged = false;
  double squared_sigmas = 0.0;  // of the beams' four parameters, summed
  int parameters = 0;
};

/// Of the points within a tenth of a depth, their distances scaled to it: they grow with the depth squared. A board
/// counts with at least six of them.
PlaneFigures planes_at(const std::vector<HeldOutDot>& dots, double depth_m) {
  std::map<int, std::vector<double>> squares_of_board;
  for (const HeldOutDot& dot : dots) {
    if (std::abs(dot.depth_m - depth_m) > 0.1 * depth_m) continue;
    squares_of_board[dot.view].push_back(std::pow(1e3 * dot.off_board_m, 2) * std::pow(depth_m / dot.depth_m, 4));
  }
  std::vector<double> planes, all;
  const auto rms = [](const std::vector<double>& squares) {
    return std::sqrt(std::accumulate(squares.begin(), squares.end(), 0.0) / static_cast<double>(squares.size()));
  };
  for (const auto& [board, squares] : squares_of_board) {
    all.insert(all.end(), squares.begin(), squares.end());
    if (squares.size() >= 6) planes.push_back(rms(squares));
  }
  return planes.empty() ? PlaneFigures{} : PlaneFigures{median(planes), rms(all)};
}

std::vector<std::optional<Rigid3>> true_poses(const Simulation& simulation) {
  std::vector<std::optional<Rigid3>> rig_from_target;
  for (const TargetView& view : simulation.problem.views) {
    const auto pose = std::ranges::find(simulation.poses, view.frame, &BoardPose::frame);
    rig_from_target.push_back(pose->rig_from_target);
  }
  return rig_from_target;
}

std::vector<HeldOutDot> explained(const Calibration& calibration, const Simulation& held_out) {
  return explain_dots(calibration, held_out.problem, true_poses(held_out), 2.0);
}

// Five new frames of the rig when its laser is ten kelvins warmer.
void add_drift(const SimulatedRig& rig, SimulateOptions options, Calibration found, Figures& figures) {
  options.frames = 5;
  options.seed += 2000000;
  options.warmer_K = 10.0;
  const Simulation warm = simulate(rig, options);
  figures.warm_mm = depth_bias_mm(warm.truth, found);
  const auto wavelength = estimate_wavelength(found, warm.problem, true_poses(warm));
  if (!wavelength) return;
  const double truth = 1.0 + options.warmer_K * rig.emitter->wavelength_drift_m_K / rig.emitter->wavelength_m;
  found.laser = at_wavelength(*found.laser, wavelength->scale);
  figures.retuned_mm = depth_bias_mm(warm.truth, found);
  figures.wavelength_sigmas = std::abs(wavelength->scale - truth) / wavelength->sigma;
}

void count_labels(const Simulation& simulation, const CalibrationResult& result, Figures& figures) {
  for (std::size_t v = 0; v < simulation.exact.views.size(); ++v) {
    const std::vector<Dot>& dots = simulation.exact.views[v].dots;
    for (std::size_t i = 0; i < dots.size(); ++i) {
      const int ours = result.views[v].beam_of_dot[i];
      figures.unlabelled += ours == kUnlabelled;
      figures.wrong_labels += ours != kUnlabelled && ours != dots[i].beam;
    }
  }
}

void add_scatter(const Calibration& truth, const Calibration& found, Figures& figures) {
  for (const LaserBeam& ours : found.laser->beams) {
    const LaserBeam* beam = beam_of(*truth.laser, ours.row, ours.column);
    const bool strong = ours.hits >= 6 && ours.farthest_hit_m - ours.nearest_hit_m >= 0.3;
    if (beam == nullptr || !strong) continue;  // the others lean on the grating's model, which errs as it errs
    const Eigen::Vector4d motion = motion_between(ours.line, beam->line);
    figures.squared_sigmas += motion.dot(ours.covariance.ldlt().solve(motion));
    figures.parameters += 4;
  }
}

/// Grids without an order zero have nothing that marks a beam: there the user clicks on one dot, a little beside it.
CalibrationProblem clicked(const Simulation& simulation) {
  CalibrationProblem problem = simulation.problem;
  if (problem.laser->brightest || !problem.laser->missing.empty()) return problem;
  const LaserGrid& grid = problem.laser->grid;
  int nearest = grid.size();
  for (std::size_t v = 0; v < simulation.exact.views.size(); ++v) {
    for (const Dot& dot : simulation.exact.views[v].dots) {
      const int distance = dot.beam < 0 ? grid.size()
                                        : std::abs(grid.row(dot.beam) - grid.rows / 2) +
                                              std::abs(grid.column(dot.beam) - grid.columns / 2);
      if (distance >= nearest) continue;
      nearest = distance;
      problem.laser->anchor = LaserAnchor{static_cast<int>(v), dot.pixel + Eigen::Vector2d(0.5, -0.5), dot.beam};
    }
  }
  return problem;
}

Figures run(const SimulatedRig& rig, int frames, std::uint64_t seed) {
  SimulateOptions options;
  options.frames = frames;
  options.seed = seed;
  options.labelled = false;
  const Simulation simulation = simulate(rig, options);
  Figures figures;
  const CalibrationResult result = calibrate(clicked(simulation));
  if (!result.calibration.laser) {
    std::printf("  seed %llu: %s\n", static_cast<unsigned long long>(seed), result.warnings.back().c_str());
    return figures;
  }
  figures.converged = result.termination == Termination::kConverged;
  figures.depth_bias_mm = depth_bias_mm(simulation.truth, result.calibration);
  count_labels(simulation, result, figures);
  add_scatter(simulation.truth, result.calibration, figures);
  if (figures.wrong_labels > 0) {
    std::printf("  seed %llu: %d wrong labels; %s\n", static_cast<unsigned long long>(seed), figures.wrong_labels,
                result.laser->label_origin.c_str());
  }
  add_drift(rig, options, result.calibration, figures);
  options.frames = 40;
  options.seed = seed + 1000000;
  const Simulation held_out = simulate(rig, options);
  const std::vector<HeldOutDot> dots = explained(result.calibration, held_out);
  const std::vector<HeldOutDot> ideal = explained(simulation.truth, held_out);
  figures.half = planes_at(dots, 0.5);
  figures.one = planes_at(dots, 1.0);
  figures.floor_half = planes_at(ideal, 0.5);
  figures.floor_one = planes_at(ideal, 1.0);
  return figures;
}

struct Spread {
  double median = 0.0, worst = 0.0;
};

template <typename Figure>
Spread spread_of(const std::vector<Figures>& all, Figure&& figure) {
  std::vector<double> values;
  for (const Figures& figures : all) values.push_back(figure(figures));
  return {median(values), *std::ranges::max_element(values)};
}

bool report_planes(const char* depth, const std::vector<Figures>& all, PlaneFigures Figures::*ours,
                   PlaneFigures Figures::*floor, double bar_mm) {
  const Spread plane = spread_of(all, [&](const Figures& f) { return (f.*ours).plane_mm; });
  const auto middle = [&](auto figure) { return spread_of(all, figure).median; };
  const bool good = plane.median <= bar_mm;
  std::printf("  held-out planes, %-5s  %6.2f (%.2f) mm, bar %.0f  %s; with the true calibration %.2f\n", depth,
              plane.median, plane.worst, bar_mm, good ? "pass" : "FAIL",
              middle([&](const Figures& f) { return (f.*floor).plane_mm; }));
  std::printf("    all their dots, rms    %6.2f mm; with the true calibration %.2f\n",
              middle([&](const Figures& f) { return (f.*ours).dots_mm; }),
              middle([&](const Figures& f) { return (f.*floor).dots_mm; }));
  return good;
}

bool report(const char* grid, int views, const std::vector<Figures>& all) {
  const Spread bias = spread_of(all, [](const Figures& f) { return f.depth_bias_mm; });
  int wrong = 0, unlabelled = 0, converged = 0, parameters = 0;
  double squares = 0.0;
  for (const Figures& figures : all) {
    wrong += figures.wrong_labels;
    unlabelled += figures.unlabelled;
    converged += figures.converged;
    squares += figures.squared_sigmas;
    parameters += figures.parameters;
  }
  const double bias_bar = views >= 60 ? 2.0 : 4.0;
  const double scatter = squares / std::max(1, parameters);
  const bool good_bias = bias.median <= bias_bar, good_labels = wrong == 0,
             good_convergence = converged == static_cast<int>(all.size()),
             good_scatter = std::abs(std::sqrt(scatter) - 1.0) <= 0.1;
  const auto word = [](bool good) { return good ? "pass" : "FAIL"; };
  std::printf("%s, %d views, %zu seeds\n", grid, views, all.size());
  std::printf("  depth bias at 1 m       %6.2f (%.2f) mm, bar %.0f  %s\n", bias.median, bias.worst, bias_bar,
              word(good_bias));
  const Spread warm = spread_of(all, [](const Figures&f) { return f.warm_mm; }),
               retuned = spread_of(all, [](const Figures&f) { return f.retuned_mm; }),
               sigmas = spread_of(all, [](const Figures&f) { return f.wavelength_sigmas; });
  const bool good_drift = retuned.median <= 4.0;
  const bool good_planes = report_planes("0.5 m", all, &Figures::half, &Figures::floor_half, 2.0) &
                           report_planes("1 m", all, &Figures::one, &Figures::floor_one, 6.0);
  std::printf(
      "  10 K warmer, 1 m        %6.2f (%.2f) mm, bar 4  %s; %.2f before; the wavelength is off by %.1f (%.1f) "
      "sigmas\n",
      retuned.median, retuned.worst, word(good_drift), warm.median, sigmas.median, sigmas.worst);
  std::printf("  wrong labels            %d, bar 0  %s; %d dots unlabelled\n", wrong, word(good_labels), unlabelled);
  std::printf("  converged               %d of %zu  %s\n", converged, all.size(), word(good_convergence));
  std::printf("  beams against their covariance: rms %.3f sigmas, bar 0.9 to 1.1  %s\n", std::sqrt(scatter),
              word(good_scatter));
  std::fflush(stdout);
  return good_bias && good_labels && good_convergence && good_scatter && good_planes && good_drift;
}

}  // namespace

int main(int argc, char** argv) {
  const int seeds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 20;
  const std::string wanted = argc > 2 ? argv[2] : "all";
  const int only = argc > 3 ? std::atoi(argv[3]) : 0;
  bool passed = true;
  for (const auto& [name, grid] : {std::pair{"11x11", LaserGrid{11, 11}}, std::pair{"19x16", LaserGrid{16, 19}}}) {
    if (wanted != "all" && wanted != name) continue;
    SimulatedRig rig = read_rig(RAYBUNDLE_SOURCE_DIR "/datasets/rigs/rig_26mm_laser.toml");
    if (grid.rows != rig.emitter->grid.rows || grid.columns != rig.emitter->grid.columns) set_grid(*rig.emitter, grid);
    for (const int views : {20, 60}) {
      if (only != 0 && only != views) continue;
      std::vector<Figures> all;
      for (int seed = 1; seed <= seeds; ++seed) all.push_back(run(rig, views, static_cast<std::uint64_t>(seed)));
      passed &= report(name, views, all);
    }
  }
  return passed ? EXIT_SUCCESS : EXIT_FAILURE;
}
