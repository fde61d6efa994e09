// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "beam_origin.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>

#include "grating_fit.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/quantile.hpp"

namespace raybundle {
namespace {

constexpr std::size_t kFewestToTell = 12;  // lines: more than the common model's 12 parameters need
constexpr double kPlainly = 0.85;          // of the most light: as bright, as far as ink and speckle let one say
constexpr double kOutshines = 1.25;        // of the usual beam's light

using Places = std::vector<std::optional<LatticePlace>>;

struct Shift {
  int row = 0;
  int column = 0;
};

struct Extent {
  int first = std::numeric_limits<int>::max();
  int last = std::numeric_limits<int>::min();
  int count() const { return last < first ? 0 : last - first + 1; }
};

// Rows or columns in use. One line alone at the rim of its lattice may be a chance alignment and does not count, unless
// all are alone, as the columns of a single row.
Extent extent_of(const Places& places, int LatticePlace::*coordinate) {
  std::vector<int> values;
  for (const auto& place : places) {
    if (place) values.push_back((*place).*coordinate);
  }
  Extent extent;
  for (const int fewest : {2, 1}) {
    if (extent.count() > 0) break;
    for (int value : values) {
      if (std::ranges::count(values, value) < fewest) continue;
      extent.first = std::min(extent.first, value);
      extent.last = std::max(extent.last, value);
    }
  }
  return extent;
}

std::optional<int> beam_at(const LaserGrid& grid, const LatticePlace& place, Shift shift) {
  const int row = place.row + shift.row;
  const int column = place.column + shift.column;
  if (row < 0 || row >= grid.rows || column < 0 || column >= grid.columns) return std::nullopt;
  return grid.index(row, column);
}

std::string grid_words(int rows, int columns) {
  return std::to_string(rows) + " rows of " + std::to_string(columns) + " beams";
}

std::vector<Shift> shifts_into(const LaserGrid& grid, const Extent& rows, const Extent& columns) {
  std::vector<Shift> shifts;
  for (int row = 0; row + rows.count() <= grid.rows; ++row) {
    for (int column = 0; column + columns.count() <= grid.columns; ++column) {
      shifts.push_back({row - rows.first, column - columns.first});
    }
  }
  return shifts;
}

// The line that passes nearest to the click, by far: the dot itself may have been left out.
const LatticePlace& place_of_anchor(const LaserScene& scene, const std::vector<HitLine>& lines, const Places& places) {
  constexpr double kNear2 = 30.0 * 30.0;  // squared sigmas, of about a pixel: a click by hand
  constexpr double kByFar2 = 2.0 * 2.0;   // a third of the way between two dots at the most
  const LaserAnchor& anchor = *scene.problem.laser->anchor;
  const std::optional<BeamHit> clicked = hit_at(scene, anchor.view, anchor.pixel);
  double nearest = std::numeric_limits<double>::infinity(), second = nearest;
  const LatticePlace* found = nullptr;
  for (std::size_t l = 0; l < lines.size() && clicked; ++l) {
    if (!places[l]) continue;
    const double distance = squared_sigmas(lines[l].line, *clicked);
    second = std::min(second, std::max(nearest, distance));
    if (distance >= nearest) continue;
    nearest = distance;
    found = &*places[l];
  }
  if (found == nullptr || nearest > kNear2 || second < kByFar2 * nearest) {
    throw Error(
        ErrorKind::kBadInput,
        "the laser's anchor is not within 30 px of a dot that lines up with others, and nearer to it than to any "
        "second one; click on another dot",
        view_name(scene.problem, scene.problem.views[anchor.view]));
  }
  return *found;
}

// The beam that the dots of a line are labelled with, of lines that have labels.
std::map<std::size_t, int> labels_of_lines(const CalibrationProblem& problem, const std::vector<BeamHit>& hits,
                                           const std::vector<HitLine>& lines) {
  std::map<std::size_t, int> labels;
  for (std::size_t l = 0; l < lines.size(); ++l) {
    for (const int i : lines[l].hits) {
      const int beam = problem.views[hits[i].view].dots[hits[i].dot].beam;
      if (beam != kUnlabelled) labels.emplace(l, beam);
    }
  }
  return labels;
}

// How much light a line's dots send, whatever their distance and the board's tilt: the upper quartile, because ink
// hides some of it. Nothing with too few of them to say.
std::optional<double> light_of(const CalibrationProblem& problem, const std::vector<BeamHit>& hits,
                               const HitLine& line) {
  constexpr std::size_t kFewestHits = 4;  // fewer may all lie on ink
  std::vector<double> values;
  for (int i : line.hits) {
    const Dot& dot = problem.views[hits[i].view].dots[hits[i].dot];
    values.push_back(dot.brightness * hits[i].x_in_rig.squaredNorm() / hits[i].cosine);
  }
  return values.size() < kFewestHits ? std::nullopt : std::optional(quantile(values, 0.75));
}

// The shifts that call one of the brightest of the beams in question the brightest; all when brightness does not tell.
// A beam of which too little was seen may be it as long as no other outshines the usual beam.
std::vector<Shift> brightest_shifts(const CalibrationProblem& problem, const std::vector<BeamHit>& hits,
                                    const std::vector<HitLine>& lines, const Places& places,
                                    const std::vector<Shift>& shifts) {
  std::vector<std::optional<double>> light(shifts.size());
  std::vector<double> usual;
  for (std::size_t l = 0; l < lines.size(); ++l) {
    const std::optional<double> sent = light_of(problem, hits, lines[l]);
    if (!places[l] || !sent) continue;
    usual.push_back(*sent);
    for (std::size_t s = 0; s < shifts.size(); ++s) {
      if (beam_at(problem.laser->grid, *places[l], shifts[s]) == *problem.laser->brightest) light[s] = sent;
    }
  }
  const double most = std::ranges::max_element(light)->value_or(0.0);
  const bool outshines = !usual.empty() && most > kOutshines * quantile(usual, 0.75);
  std::vector<Shift> kept;
  for (std::size_t s = 0; s < shifts.size(); ++s) {
    if (light[s] ? *light[s] >= kPlainly * most : !outshines) kept.push_back(shifts[s]);
  }
  return kept;
}

// The beam that plainly outshines both the usual one and the one that is said to be the brightest.
std::optional<int> brighter_than_said(const CalibrationProblem& problem, const std::vector<BeamHit>& hits,
                                      const std::vector<HitLine>& lines, const std::vector<int>& beam_of_line) {
  std::vector<double> usual;
  std::optional<double> said;
  std::optional<int> brightest;
  double most = 0.0;
  for (std::size_t l = 0; l < lines.size(); ++l) {
    const std::optional<double> sent = light_of(problem, hits, lines[l]);
    if (!sent || beam_of_line[l] == kUnlabelled) continue;
    usual.push_back(*sent);
    if (beam_of_line[l] == *problem.laser->brightest) said = sent;
    if (*sent <= most) continue;
    most = *sent;
    brightest = beam_of_line[l];
  }
  const bool outshines = !usual.empty() && most > kOutshines * quantile(usual, 0.75);
  return outshines && said.value_or(0.0) < kPlainly * most ? brightest : std::nullopt;
}

// The shifts for which the lines follow the common model about as well as for any: its lens bends the beams around the
// zero order. All when the model does not tell.
std::vector<Shift> fitting_shifts(const LaserGrid& grid, int zero_order, const std::vector<HitLine>& lines,
                                  const Places& places, const std::vector<Shift>& shifts) {
  constexpr std::size_t kMostShifts = 32;  // a fit each
  constexpr double kAboutAsWell = 2.0;     // as the best
  constexpr int kManyLines = 24;           // that need no help from lines that lean on the source
  if (shifts.size() > kMostShifts) return shifts;
  const auto sure = std::ranges::count(lines, false, &HitLine::leans_on_source);
  std::vector<double> rms_rad;
  for (const Shift shift : shifts) {
    std::vector<OrderedLine> ordered;
    for (std::size_t l = 0; l < lines.size(); ++l) {
      if (!places[l] || (lines[l].leans_on_source && sure >= kManyLines)) continue;
      ordered.push_back({.m = static_cast<double>(places[l]->column + shift.column - grid.column(zero_order)),
                         .n = static_cast<double>(places[l]->row + shift.row - grid.row(zero_order)),
                         .line = lines[l].line});
    }
    if (ordered.size() < kFewestToTell) return shifts;
    const std::optional<GratingFit> fit = fit_grating(ordered);
    rms_rad.push_back(fit ? fit->rms_rad : std::numeric_limits<double>::infinity());
  }
  const double best_rad = *std::ranges::min_element(rms_rad);
  std::vector<Shift> kept;
  for (std::size_t s = 0; s < shifts.size(); ++s) {
    if (rms_rad[s] <= kAboutAsWell * best_rad) kept.push_back(shifts[s]);
  }
  return kept;
}

std::string beam_words(const LaserGrid& grid, int beam) {
  return "row " + std::to_string(grid.row(beam)) + ", column " + std::to_string(grid.column(beam));
}

// By quarters. One puts columns down the image and rows to its left: a turn, where exchanging them would mirror the
// grid.
LatticePlace turned(LatticePlace place, int quarters) {
  for (; quarters > 0; --quarters) place = {-place.column, place.row};
  return place;
}

Places turned(Places places, int quarters) {
  for (auto& place : places) {
    if (place) place = turned(*place, quarters);
  }
  return places;
}

// What says which beam is which, of a lattice that is turned by so many quarters.
BeamOrigin origin_of_turned(const LaserScene& scene, const std::vector<BeamHit>& hits,
                            const std::vector<HitLine>& lines, const Places& given_places, int quarters) {
  const CalibrationProblem& problem = scene.problem;
  const ProblemLaser& laser = *problem.laser;
  const Places places = turned(given_places, quarters);
  const Extent rows = extent_of(places, &LatticePlace::row), columns = extent_of(places, &LatticePlace::column);
  std::vector<Shift> shifts = shifts_into(laser.grid, rows, columns);
  if (shifts.empty()) {
    throw Error(ErrorKind::kNotEnoughData, "the dots form " + grid_words(rows.count(), columns.count()) +
                                               ", more than the " + grid_words(laser.grid.rows, laser.grid.columns) +
                                               " that the laser is said to have; mend its rows and columns");
  }
  BeamOrigin origin{.beam_of_line = std::vector<int>(lines.size(), kUnlabelled),
                    .reason = "the outermost rows and columns"};
  const auto keep = [&](const std::string& reason, auto&& agrees) {
    if (shifts.size() > 1) origin.reason = reason;
    std::erase_if(shifts, [&](Shift shift) { return !agrees(shift); });
    if (shifts.empty()) {
      throw Error(ErrorKind::kBadInput, "no numbering of the dots agrees with " + reason +
                                            " of the laser; mend the description or leave it out");
    }
  };
  const std::map<std::size_t, int> labels = labels_of_lines(problem, hits, lines);
  if (!labels.empty()) {
    keep("the labels given", [&](Shift shift) {
      return std::ranges::all_of(labels, [&](const auto& label) {
        const auto& [line, beam] = label;
        return !places[line] || beam_at(laser.grid, *places[line], shift) == beam;
      });
    });
  }
  if (laser.anchor) {
    const LatticePlace& place = place_of_anchor(scene, lines, given_places);
    const LatticePlace anchored = turned(place, quarters);
    keep("the anchor", [&](Shift shift) { return beam_at(laser.grid, anchored, shift) == laser.anchor->beam; });
  }
  const auto narrow = [&](std::vector<Shift> fitting, const char* reason) {
    if (fitting.size() < shifts.size()) origin.reason = reason;
    shifts = std::move(fitting);
  };
  if (laser.brightest && shifts.size() > 1) {
    narrow(fitting_shifts(laser.grid, *laser.brightest, lines, places, shifts),
           "the lens's bending of the lattice about the brightest beam");
  }
  if (laser.brightest && shifts.size() > 1) {
    narrow(brightest_shifts(problem, hits, lines, places, shifts), "the brightest beam");
  }
  if (!laser.missing.empty()) {
    keep("the missing beams", [&](Shift shift) {
      return std::ranges::none_of(places, [&](const auto& place) {
        const std::optional<int> beam = place ? beam_at(laser.grid, *place, shift) : std::nullopt;
        return beam && std::ranges::count(laser.missing, *beam) > 0;
      });
    });
  }
  if (shifts.size() > 1) {
    origin.guessed = true;
    origin.reason = "nothing: " + grid_words(rows.count(), columns.count()) +
                    " were seen, taken for the middle ones; " +
                    (laser.brightest ? "give an anchor, or name a missing beam"
                                     : "name the brightest or a missing beam, or give an anchor");
  }
  const Shift shift = shifts[shifts.size() / 2];
  for (std::size_t l = 0; l < lines.size(); ++l) {
    if (places[l]) origin.beam_of_line[l] = beam_at(laser.grid, *places[l], shift).value_or(kUnlabelled);
  }
  const auto brighter = laser.brightest ? brighter_than_said(problem, hits, lines, origin.beam_of_line) : std::nullopt;
  if (brighter && !origin.guessed) {
    origin.reason += ", by which not " + beam_words(laser.grid, *laser.brightest) +
                     " is the brightest, as is said, but " + beam_words(laser.grid, *brighter);
  }
  return origin;
}

}  // namespace

BeamOrigin beam_origin(const LaserScene& scene, const std::vector<BeamHit>& hits, const std::vector<HitLine>& lines,
                       const Places& places) {
  const ProblemLaser& laser = *scene.problem.laser;
  const int rows = extent_of(places, &LatticePlace::row).count();
  const int columns = extent_of(places, &LatticePlace::column).count();
  const bool upright = rows <= laser.grid.rows && columns <= laser.grid.columns;
  const bool turned = rows <= laser.grid.columns && columns <= laser.grid.rows;
  // Dots whose beams are named may say that the projector is turned; otherwise it is only where it must be.
  const bool named = laser.anchor || !labels_of_lines(scene.problem, hits, lines).empty();
  std::optional<Error> refusal;
  for (int quarters = 0; named && quarters < 4; ++quarters) {
    if (quarters % 2 == 0 ? !upright : !turned) continue;
    try {
      return origin_of_turned(scene, hits, lines, places, quarters);
    } catch (const Error& error) {
      if (!refusal) refusal = error;
    }
  }
  if (refusal) throw Error(*refusal);
  if (upright || !turned) return origin_of_turned(scene, hits, lines, places, 0);
  BeamOrigin origin = origin_of_turned(scene, hits, lines, places, 1);
  origin.reason += fmt::format(
      "; {} were seen, so that the projector is taken to be turned by a quarter: or has the grid {} columns and {} rows?",
      grid_words(rows, columns), laser.grid.rows, laser.grid.columns);
  return origin;
}

}  // namespace raybundle
