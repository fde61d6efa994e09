// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/initialize/beam_start.hpp"

#include <algorithm>
#include <map>

#include "beam_hits.hpp"
#include "beam_lattice.hpp"
#include "beam_lines.hpp"
#include "beam_origin.hpp"
#include "grating_fit.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

constexpr double kOnBeam = 25.0;     // squared sigmas up to which a dot may be a beam's
constexpr double kAmbiguous = 16.0;  // a second beam that is hardly farther off makes the label unsure

using BeamLines = std::map<int, HitLine>;  // by beam

// Lines of the beams that dots are labelled with already.
BeamLines labelled_lines(const CalibrationProblem& problem, const std::vector<BeamHit>& hits) {
  BeamLines lines;
  for (int i = 0; i < static_cast<int>(hits.size()); ++i) {
    const int beam = problem.views[hits[i].view].dots[hits[i].dot].beam;
    if (beam != kUnlabelled) lines[beam].hits.push_back(i);
  }
  std::erase_if(lines, [](const auto& entry) { return entry.second.hits.size() < 2; });
  for (auto& [beam, line] : lines) {
    Eigen::Matrix3Xd points(3, line.hits.size());
    for (std::size_t i = 0; i < line.hits.size(); ++i) {
      points.col(static_cast<Eigen::Index>(i)) = hits[line.hits[i]].x_in_rig;
    }
    line.line = line_through(points, {}, points.rowwise().mean());
    refit(hits, line);
  }
  return lines;
}

// Of so few dots most often the images are wrong, of many the poses.
std::string why_no_grid(const LaserScene& scene, std::size_t dots, std::size_t lines) {
  constexpr double kFewOfView = 3.0;
  const auto views = std::ranges::count_if(scene.rig_from_target,
                                           [](const auto& rig_from_target) { return rig_from_target.has_value(); });
  const std::string counted = std::to_string(dots) + " dots in " + std::to_string(views) + " views";
  if (static_cast<double>(dots) < kFewOfView * static_cast<double>(views)) {
    return "hardly any laser dot was found on the boards (" + counted +
           "); are the images with the laser on and off swapped, of different poses or overexposed, or does the laser "
           "miss the board?";
  }
  return "the laser dots of different board poses do not line up to a grid of beams (" + counted + ", " +
         std::to_string(lines) +
         " lines); do the images with the laser on belong to the poses of those with it off, and did the projector "
         "stand still? If so take 20 or more poses at distances that differ by half";
}

BeamLines unlabelled_lines(const LaserScene& scene, const std::vector<BeamHit>& hits, BeamStart& start) {
  const std::vector<HitLine> found = lines_through_hits(scene, hits);
  std::vector<Line3> directions;
  std::vector<double> weights;
  for (const HitLine& line : found) {
    directions.push_back(line.line);
    weights.push_back(static_cast<double>(line.hits.size()));
  }
  const auto places = lattice_places(directions, weights);
  if (std::ranges::count_if(places, [](const auto& place) { return place.has_value(); }) < 4) {
    throw Error(ErrorKind::kNotEnoughData, why_no_grid(scene, hits.size(), found.size()));
  }
  const BeamOrigin origin = beam_origin(scene, hits, found, places);
  start.origin = origin.reason;
  start.origin_guessed = origin.guessed;
  BeamLines lines;
  for (std::size_t l = 0; l < found.size(); ++l) {
    if (origin.beam_of_line[l] != kUnlabelled) lines[origin.beam_of_line[l]] = found[l];
  }
  return lines;
}

bool sure_line(const BeamLines& lines, int beam) {
  const auto found = lines.find(beam);
  return found != lines.end() && !found->second.leans_on_source;
}

void fit_common_model(const LaserScene& scene, const BeamLines& lines, BeamStart& start) {
  constexpr int kManyLines = 24;            // that need no help from lines that lean on the source
  constexpr double kMaxShareOfPitch = 0.1;  // a projector that is farther from a grating is none
  const ProblemLaser& laser = *scene.problem.laser;
  const int size = laser.grid.size();
  start.zero_order_row = laser.brightest ? laser.grid.row(*laser.brightest) : 0.5 * (laser.grid.rows - 1);
  start.zero_order_column = laser.brightest ? laser.grid.column(*laser.brightest) : 0.5 * (laser.grid.columns - 1);
  std::vector<OrderedLine> ordered;
  const auto sure = std::ranges::count_if(lines, [](const auto& entry) { return !entry.second.leans_on_source; });
  for (const auto& [beam, line] : lines) {
    if (line.leans_on_source && sure >= kManyLines) continue;
    ordered.push_back(
        {laser.grid.column(beam) - start.zero_order_column, laser.grid.row(beam) - start.zero_order_row, line.line});
  }
  start.lines.resize(size);
  for (const auto& [beam, line] : lines) start.lines[beam] = line.line;
  const std::optional<GratingFit> fit = fit_grating(ordered);
  if (!fit || fit->rms_rad > kMaxShareOfPitch * std::min(fit->grating.column_pitch, fit->grating.row_pitch)) return;
  start.grating = fit->grating;
  start.grating_rms_rad = fit->rms_rad;
  for (int beam = 0; beam < size; ++beam) {
    if (sure_line(lines, beam) || std::ranges::count(laser.missing, beam) > 0) continue;
    start.lines[beam] = beam_of_order(fit->grating, laser.grid.column(beam) - start.zero_order_column,
                                      laser.grid.row(beam) - start.zero_order_row);
  }
}

/// A beam that may have made a dot.
struct Candidate {
  int beam = kUnlabelled;
  double squared_sigmas = kOnBeam;
};

// Each dot goes to the beam that explains it, unless a second one does nearly as well.
Candidate beam_of_hit(const BeamHit& hit, const BeamLines& fitted, const BeamStart& start) {
  Candidate best, second{kUnlabelled, kOnBeam + kAmbiguous};
  for (int beam = 0; beam < static_cast<int>(start.lines.size()); ++beam) {
    if (!start.lines[beam]) continue;
    const Line3& line = *start.lines[beam];
    const double range = (hit.x_in_rig - line.point).norm();
    const double unsure_m = sure_line(fitted, beam) ? 0.0 : start.grating_rms_rad * range;
    if (distance_between(line, hit.x_in_rig) > 0.1 * hit.x_in_rig.norm()) continue;
    const Candidate candidate{beam, squared_sigmas(line, hit, unsure_m * unsure_m * Eigen::Matrix3d::Identity())};
    if (candidate.squared_sigmas < best.squared_sigmas) {
      if (best.beam != kUnlabelled) second = best;
      best = candidate;
    } else if (candidate.squared_sigmas < second.squared_sigmas) {
      second = candidate;
    }
  }
  const bool ambiguous = second.beam != kUnlabelled && second.squared_sigmas < best.squared_sigmas + kAmbiguous;
  return ambiguous ? Candidate{} : best;
}

void label_dots(const LaserScene& scene, const std::vector<BeamHit>& hits, const BeamLines& lines, BeamStart& start) {
  const std::vector<TargetView>& views = scene.problem.views;
  std::map<std::pair<int, int>, std::pair<double, int>> taken;  // (view, beam) -> (squared sigmas, hit)
  std::vector<int> label(hits.size(), kUnlabelled);
  for (int i = 0; i < static_cast<int>(hits.size()); ++i) {
    const int known = views[hits[i].view].dots[hits[i].dot].beam;
    const Candidate candidate = known != kUnlabelled ? Candidate{known, -1.0} : beam_of_hit(hits[i], lines, start);
    if (candidate.beam == kUnlabelled) continue;
    const auto [place, fresh] = taken.try_emplace({hits[i].view, candidate.beam}, candidate.squared_sigmas, i);
    if (!fresh && place->second.first <= candidate.squared_sigmas) continue;
    if (!fresh) label[place->second.second] = kUnlabelled;
    place->second = {candidate.squared_sigmas, i};
    label[i] = candidate.beam;
  }
  start.beam_of_dot.resize(views.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (std::size_t d = 0; d < views[v].dots.size(); ++d) {
      start.beam_of_dot[v].push_back(start.on_board[v][d] ? views[v].dots[d].beam : kUnlabelled);
    }
  }
  for (std::size_t i = 0; i < hits.size(); ++i) start.beam_of_dot[hits[i].view][hits[i].dot] = label[i];
}

bool most_are_labelled(const CalibrationProblem& problem, const std::vector<BeamHit>& hits) {
  const auto labelled = std::ranges::count_if(
      hits, [&](const BeamHit& hit) { return problem.views[hit.view].dots[hit.dot].beam != kUnlabelled; });
  return 2 * labelled >= std::ssize(hits);
}

// A few labels say which beam is which, but not where the others are: they are found as without labels, where they can
// and the labels agree.
BeamLines more_lines(const LaserScene& scene, const std::vector<BeamHit>& hits, const BeamLines& labelled,
                     BeamStart& start) {
  BeamStart with_more = start;
  try {
    BeamLines found = unlabelled_lines(scene, hits, with_more);
    for (const auto& [beam, line] : labelled) found.insert_or_assign(beam, line);
    start = std::move(with_more);
    return found;
  } catch (const Error&) {
    return labelled;
  }
}

}  // namespace

BeamStart initialize_beams(const LaserScene& scene) {
  BeamStart start;
  start.on_board = dots_on_boards(scene);
  const std::vector<BeamHit> hits = hits_on_boards(scene, start.on_board);
  BeamLines lines = labelled_lines(scene.problem, hits);
  start.origin = "the labels given";
  if (lines.empty()) {
    lines = unlabelled_lines(scene, hits, start);
  } else if (!most_are_labelled(scene.problem, hits)) {
    lines = more_lines(scene, hits, lines, start);
  }
  fit_common_model(scene, lines, start);
  label_dots(scene, hits, lines, start);
  return start;
}

}  // namespace raybundle
