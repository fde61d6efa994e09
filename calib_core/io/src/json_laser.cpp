// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "json_laser.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <string>

namespace raybundle {
namespace {

constexpr int kMostRows = 4096;  // of a grid; far above any grating, far below what overflows
constexpr int kMaxCount = std::numeric_limits<int>::max();

LaserGrid grid_from(const JsonNode& node) {
  return {node.at("rows").whole_number(1, kMostRows), node.at("columns").whole_number(1, kMostRows)};
}

OrderedJson number_or_null(double value) { return std::isfinite(value) ? OrderedJson(value) : OrderedJson(nullptr); }

// Where a beam has no depth at a distance, its numbers are null.
OrderedJson json_from_depths(const LaserBeam& beam) {
  OrderedJson depths = OrderedJson::array();
  for (std::size_t d = 0; d < kStatedDepths_m.size(); ++d) {
    depths.push_back({{"depth_m", kStatedDepths_m[d]},
                      {"sigma_m", number_or_null(beam.depths[d].sigma_m)},
                      {"per_px_m", number_or_null(beam.depths[d].per_px_m)}});
  }
  return depths;
}

OrderedJson json_from_beam(const LaserBeam& beam) {
  OrderedJson covariance = OrderedJson::array();
  for (int i = 0; i < 4; ++i) covariance.push_back(json_from_vector(beam.covariance.row(i).transpose()));
  return {{"row", beam.row},
          {"column", beam.column},
          {"point_m", json_from_vector(beam.line.point)},
          {"direction", json_from_vector(beam.line.direction)},
          {"covariance", covariance},
          {"hits", beam.hits},
          {"nearest_hit_m", beam.nearest_hit_m},
          {"farthest_hit_m", beam.farthest_hit_m},
          {"depths", json_from_depths(beam)}};
}

double number_or_nan(const JsonNode& node) {
  return node.is_null() ? std::numeric_limits<double>::quiet_NaN() : node.number();
}

void read_depths(const JsonNode& node, LaserBeam& beam) {
  node.expect_array_size(kStatedDepths_m.size());
  for (std::size_t d = 0; d < kStatedDepths_m.size(); ++d) {
    const JsonNode entry = node[d];
    if (entry.at("depth_m").number() != kStatedDepths_m[d]) entry.fail("has another depth than this version states");
    beam.depths[d] = {number_or_nan(entry.at("sigma_m")), number_or_nan(entry.at("per_px_m"))};
  }
}

Eigen::Vector3d direction_from(const JsonNode& node) {
  const Eigen::Vector3d direction = node.vector<3>();
  const double excess = std::abs(direction.norm() - 1.0);
  if (!(excess < 1e-3)) node.fail("is no unit vector; divide it by its length");
  return excess < 1e-12 ? direction : Eigen::Vector3d(direction.normalized());
}

Eigen::Matrix4d covariance_from(const JsonNode& rows) {
  rows.expect_array_size(4);
  Eigen::Matrix4d covariance;
  for (int i = 0; i < 4; ++i) {
    const JsonNode row = rows[static_cast<std::size_t>(i)];
    covariance.row(i) = row.vector<4>().transpose();
    if (covariance(i, i) < 0) row.fail("has a negative variance on the diagonal; correct it");
  }
  if (covariance != covariance.transpose()) rows.fail("is not symmetric; correct it");
  constexpr double kRounding = 1e-9;  // of numbers that were written with fewer digits than they have
  const Eigen::Vector4d variances = Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(covariance).eigenvalues();
  if (variances.minCoeff() < -kRounding * variances.maxCoeff()) {
    rows.fail("is no covariance, as the variance in one of its directions is negative; correct it");
  }
  return covariance;
}

LaserBeam beam_from(const JsonNode& node, const LaserGrid& grid) {
  LaserBeam beam;
  beam.row = node.at("row").whole_number(0, grid.rows - 1);
  beam.column = node.at("column").whole_number(0, grid.columns - 1);
  beam.line = {node.at("point_m").vector<3>(), direction_from(node.at("direction"))};
  beam.covariance = covariance_from(node.at("covariance"));
  if (const auto hits = node.find("hits")) beam.hits = hits->whole_number(0, kMaxCount);
  if (const auto nearest = node.find("nearest_hit_m")) beam.nearest_hit_m = nearest->number();
  if (const auto farthest = node.find("farthest_hit_m")) beam.farthest_hit_m = farthest->number();
  if (const auto depths = node.find("depths")) read_depths(*depths, beam);
  return beam;
}

OrderedJson json_from_grating(const Grating& grating) {
  return {{"rig_from_projector", json_from_rigid3(grating.rig_from_projector)},
          {"column_pitch", grating.column_pitch},
          {"row_pitch", grating.row_pitch},
          {"skew_rad", grating.skew_rad},
          {"k1", grating.k1},
          {"k2", grating.k2},
          {"shift_m", grating.shift_m},
          {"wavelength_scale", grating.wavelength_scale}};
}

Grating grating_from(const JsonNode& node) {
  return {node.at("rig_from_projector").rigid3(),
          node.at("column_pitch").number(),
          node.at("row_pitch").number(),
          node.at("skew_rad").number(),
          node.at("k1").number(),
          node.at("k2").number(),
          node.at("shift_m").number(),
          node.at("wavelength_scale").positive_number()};
}

OrderedJson json_from_label(const LaserGrid& grid, int beam) { return {grid.row(beam), grid.column(beam)}; }

int label_from(const JsonNode& row, const JsonNode& column, const LaserGrid& grid) {
  return grid.index(row.whole_number(0, grid.rows - 1), column.whole_number(0, grid.columns - 1));
}

int label_from(const JsonNode& node, const LaserGrid& grid) {
  node.expect_array_size(2);
  return label_from(node[0], node[1], grid);
}

OrderedJson json_from_advice(const LabelAdvice& advice, const LaserGrid& grid) {
  OrderedJson pairs = OrderedJson::array();
  for (const AmbiguousBeams& pair : advice.ambiguity.pairs) {
    pairs.push_back({{"beams", {json_from_label(grid, pair.first), json_from_label(grid, pair.second)}},
                     {"distance_px", pair.distance_px}});
  }
  OrderedJson json{{"tolerance_px", advice.ambiguity.tolerance_px},
                   {"single_candidate_share", advice.ambiguity.single_candidate_share}};
  if (advice.best_turn) {
    json["best_turn"] = {{"turn_rad", advice.best_turn->turn_rad},
                         {"single_candidate_share", advice.best_turn->single_candidate_share}};
  }
  json["ambiguous_pairs"] = pairs;
  return json;
}

LabelAdvice advice_from(const JsonNode& node, const LaserGrid& grid) {
  LabelAdvice advice;
  advice.ambiguity.tolerance_px = node.at("tolerance_px").number();
  advice.ambiguity.single_candidate_share = node.at("single_candidate_share").number();
  if (const auto turn = node.find("best_turn")) {
    advice.best_turn = TurnedPattern{turn->at("turn_rad").number(), turn->at("single_candidate_share").number()};
  }
  const JsonNode pairs = node.at("ambiguous_pairs");
  for (std::size_t i = 0; i < pairs.array_size(); ++i) {
    const JsonNode pair = pairs[i];
    const JsonNode beams = pair.at("beams");
    beams.expect_array_size(2);
    advice.ambiguity.pairs.push_back(
        {label_from(beams[0], grid), label_from(beams[1], grid), pair.at("distance_px").number()});
  }
  return advice;
}

}  // namespace

OrderedJson json_from_pattern(const LaserPattern& pattern) {
  OrderedJson json{{"rows", pattern.grid.rows},
                   {"columns", pattern.grid.columns},
                   {"zero_order_row", pattern.zero_order_row},
                   {"zero_order_column", pattern.zero_order_column}};
  if (pattern.grating) json["grating"] = json_from_grating(*pattern.grating);
  if (pattern.advice) json["label_advice"] = json_from_advice(*pattern.advice, pattern.grid);
  json["beams"] = OrderedJson::array();
  for (const LaserBeam& beam : pattern.beams) json["beams"].push_back(json_from_beam(beam));
  return json;
}

LaserPattern pattern_from(const JsonNode& node) {
  LaserPattern pattern;
  pattern.grid = grid_from(node);
  if (const auto row = node.find("zero_order_row")) pattern.zero_order_row = row->number();
  if (const auto column = node.find("zero_order_column")) pattern.zero_order_column = column->number();
  if (const auto grating = node.find("grating")) pattern.grating = grating_from(*grating);
  if (const auto advice = node.find("label_advice")) pattern.advice = advice_from(*advice, pattern.grid);
  const JsonNode beams = node.at("beams");
  for (std::size_t i = 0; i < beams.array_size(); ++i) {
    const JsonNode beam = beams[i];
    pattern.beams.push_back(beam_from(beam, pattern.grid));
    const LaserBeam& now = pattern.beams.back();
    if (i == 0) continue;
    const LaserBeam& before = pattern.beams[i - 1];
    if (pattern.grid.index(before.row, before.column) >= pattern.grid.index(now.row, now.column)) {
      beam.fail("stands after a beam of the same or a later row and column; sort the beams, each once");
    }
  }
  return pattern;
}

OrderedJson json_from_laser(const ProblemLaser& laser) {
  OrderedJson json{{"rows", laser.grid.rows}, {"columns", laser.grid.columns}};
  if (laser.anchor) {
    json["anchor"] = {{"view", laser.anchor->view},
                      {"pixel", json_from_vector(laser.anchor->pixel)},
                      {"row", laser.grid.row(laser.anchor->beam)},
                      {"column", laser.grid.column(laser.anchor->beam)}};
  }
  if (laser.brightest) json["brightest"] = json_from_label(laser.grid, *laser.brightest);
  if (!laser.missing.empty()) {
    json["missing"] = OrderedJson::array();
    for (const int beam : laser.missing) json["missing"].push_back(json_from_label(laser.grid, beam));
  }
  return json;
}

ProblemLaser laser_from(const JsonNode& node) {
  node.expect_keys({"rows", "columns", "anchor", "brightest", "missing"});
  ProblemLaser laser{grid_from(node)};
  if (const auto anchor = node.find("anchor")) {
    anchor->expect_keys({"view", "pixel", "row", "column"});
    laser.anchor = LaserAnchor{anchor->at("view").whole_number(0, kMaxCount), anchor->at("pixel").vector<2>(),
                               label_from(anchor->at("row"), anchor->at("column"), laser.grid)};
  }
  if (const auto brightest = node.find("brightest")) laser.brightest = label_from(*brightest, laser.grid);
  if (const auto missing = node.find("missing")) {
    for (std::size_t i = 0; i < missing->array_size(); ++i) {
      laser.missing.push_back(label_from((*missing)[i], laser.grid));
    }
  }
  return laser;
}

OrderedJson json_from_dots(const std::vector<Dot>& dots, const LaserGrid& grid) {
  OrderedJson rows = OrderedJson::array();
  for (const Dot& dot : dots) {
    const Eigen::Matrix2d& c = dot.covariance_px2;
    OrderedJson row{dot.pixel.x(), dot.pixel.y(), c(0, 0), c(0, 1), c(1, 1), nullptr, nullptr, dot.brightness};
    if (dot.beam != kUnlabelled) {
      row[5] = grid.row(dot.beam);
      row[6] = grid.column(dot.beam);
    }
    rows.push_back(row);
  }
  return rows;
}

std::vector<Dot> dots_from(const JsonNode& rows, const LaserGrid& grid) {
  std::vector<Dot> dots;
  for (std::size_t i = 0; i < rows.array_size(); ++i) {
    const JsonNode row = rows[i];
    const std::size_t size = row.array_size();
    if (size != 5 && size != 7 && size != 8) {
      row.fail("has " + std::to_string(size) +
               " entries; [u, v, cuu, cuv, cvv], with row, column and with brightness behind them");
    }
    Dot dot;
    dot.pixel = {row[0].number(), row[1].number()};
    const double cuu = row[2].positive_number(), cuv = row[3].number(), cvv = row[4].positive_number();
    dot.covariance_px2 << cuu, cuv, cuv, cvv;
    if (size > 5 && row[5].is_null() != row[6].is_null()) row.fail("has a row or a column, but not both");
    if (size > 5 && !row[5].is_null()) dot.beam = label_from(row[5], row[6], grid);
    if (size > 7) dot.brightness = row[7].number();
    dots.push_back(dot);
  }
  return dots;
}

}  // namespace raybundle
