// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "comparison_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "pose_json.hpp"
#include "terminal.hpp"

namespace raybundle::apps {
namespace {

using Json = nlohmann::ordered_json;

// Tenths of a thousandth of a pixel are more than enough; what is not there becomes null.
Json json_from_map(const Eigen::MatrixXd& map) {
  Json rows = Json::array();
  for (Eigen::Index row = 0; row < map.rows(); ++row) {
    Json line = Json::array();
    for (Eigen::Index column = 0; column < map.cols(); ++column) {
      line.push_back(std::round(1e4 * map(row, column)) / 1e4);
    }
    rows.push_back(line);
  }
  return rows;
}

Json json_from_differences(const std::vector<NormalizedDifference>& differences) {
  Json json = Json::array();
  for (const NormalizedDifference& d : differences) {
    json.push_back({{"name", d.name},
                    {"difference", d.difference},
                    {"sigma", d.sigma},
                    {"sigmas", d.sigmas},
                    {"beyond_any_sigma", std::isinf(d.sigmas)}});
  }
  return json;
}

Json json_from_projection(const ProjectionDifference& d) {
  return {{"camera", d.camera},
          {"range_m", std::isfinite(d.range_m) ? Json(d.range_m) : Json()},
          {"agrees", d.agrees()},
          {"share_within", d.share_within},
          {"covered_share", d.covered_share},
          {"lost_share", d.lost_share},
          {"rms_px", d.rms_px},
          {"largest_px", d.largest_px},
          {"b_from_a", json_from_pose(d.b_from_a)},
          {"map",
           {{"u_px", json_from_map(d.u_px)},
            {"v_px", json_from_map(d.v_px)},
            {"summed_sigma_px", json_from_map(d.sigma_px)}}}};
}

// The typical and the largest of some normalised differences, and those for which no sigma is large enough; nothing
// where none is uncertain and none differs.
std::string sigmas_text(const std::vector<NormalizedDifference>& differences, const std::string& unit) {
  const NormalizedDifference* worst = nullptr;
  double squares = 0.0;
  int count = 0, beyond = 0;
  for (const NormalizedDifference& d : differences) {
    beyond += std::isinf(d.sigmas);
    if (!std::isfinite(d.sigmas)) continue;
    squares += d.sigmas * d.sigmas;
    ++count;
    if (worst == nullptr || d.sigmas > worst->sigmas) worst = &d;
  }
  std::string text;
  if (worst != nullptr) {
    text = fmt::format("{} of them {:.2f} sigmas apart rms; farthest {} by {:.3g}{}, {:.1f} sigmas\n", count,
                       std::sqrt(squares / count), worst->name, worst->difference, unit, worst->sigmas);
  }
  if (beyond > 0) text += fmt::format("{}{} differ, and no sigma tells of it\n", text.empty() ? "" : "  ", beyond);
  return text;
}

}  // namespace

std::string range_text(double range_m) {
  return std::isfinite(range_m) ? fmt::format("at {:g} m", range_m) : std::string("at infinity");
}

std::string lost_text(const ProjectionDifference& d) {
  if (d.lost_share == 0.0) return {};
  return fmt::format("{} {}: one of the lenses sees nothing in {:.0f} % of the image that both saw", d.camera,
                     range_text(d.range_m), std::max(1.0, 100.0 * d.lost_share));
}

nlohmann::ordered_json json_from_comparison(const CalibrationComparison& comparison) {
  Json projections = Json::array();
  for (const ProjectionDifference& difference : comparison.projections) {
    projections.push_back(json_from_projection(difference));
  }
  return {{"agrees", comparison.agrees()},
          {"sigmas_from", comparison.sigmas_from == SigmasFrom::kFrames ? "frames" : "corners"},
          {"most_summed_sigmas", kMostSummedSigmas},
          {"least_share_within", kLeastShareWithin},
          {"projections", projections},
          {"extrinsics", json_from_differences(comparison.extrinsics)},
          {"beams", json_from_differences(comparison.beams)},
          {"not_compared", comparison.not_compared},
          {"remarks", comparison.remarks}};
}

std::string comparison_text(const CalibrationComparison& comparison) {
  std::vector<std::vector<std::string>> rows{{"camera", "points", "image", "rms px", "largest px",
                                              fmt::format("within {:g} summed sigmas", kMostSummedSigmas), ""}};
  for (const ProjectionDifference& d : comparison.projections) {
    rows.push_back({d.camera, range_text(d.range_m), fmt::format("{:.0f} %", 100 * d.covered_share),
                    fmt::format("{:.3f}", d.rms_px), fmt::format("{:.3f}", d.largest_px),
                    fmt::format("{:.0f} %", 100 * d.share_within), d.agrees() ? "agrees" : "DIFFERS"});
  }
  std::string text = text_table(rows);
  for (const ProjectionDifference& d : comparison.projections) {
    if (const std::string lost = lost_text(d); !lost.empty()) text += "note: " + lost + "\n";
  }
  const std::string extrinsics = sigmas_text(comparison.extrinsics, "");
  if (!extrinsics.empty()) text += "extrinsics: " + extrinsics;
  const std::string beams = sigmas_text(comparison.beams, " m");
  if (!beams.empty()) text += "beams: " + beams;
  for (const std::string& lonely : comparison.not_compared) text += "note: " + lonely + "\n";
  for (const std::string& remark : comparison.remarks) text += "note: " + remark + "\n";
  return text;
}

}  // namespace raybundle::apps
