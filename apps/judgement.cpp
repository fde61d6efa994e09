// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "judgement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "pose_json.hpp"
#include "raybundle/scene/number.hpp"

namespace raybundle::apps {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kMapColumns = 32;
constexpr int kNextViews = 3;
constexpr double kUsualRanges_m[] = {1.0, kInfinitelyFar};

// The requirement that fails by most, whose figure the next views should make smaller.
std::optional<Requirement> worst_requirement(const Verdict& verdict) {
  const Judgement* worst = nullptr;
  const auto excess = [](const Judgement& j) { return j.value / j.requirement.limit; };
  for (const Judgement& judgement : verdict.judgements) {
    const Quantity quantity = judgement.requirement.quantity;
    if (quantity != Quantity::kProjection && quantity != Quantity::kDepth) continue;
    if (std::isfinite(judgement.value) && (!worst || excess(judgement) > excess(*worst))) worst = &judgement;
  }
  return worst ? std::optional(worst->requirement) : std::nullopt;
}

Json json_of(const Verdict& verdict) {
  Json judgements = Json::array(), findings = Json::array();
  for (const Judgement& each : verdict.judgements) {
    judgements.push_back({{"require", each.requirement.text},
                          {"subject", each.subject},
                          {"grade", grade_name(each.grade)},
                          {"value", each.value},
                          {"limit", each.requirement.limit},
                          {"reason", each.reason},
                          {"advice", each.advice}});
  }
  for (const Finding& each : verdict.findings) {
    findings.push_back({{"subject", each.subject},
                        {"topic", each.topic},
                        {"good", each.good},
                        {"text", each.text},
                        {"advice", each.advice}});
  }
  return {{"grade", verdict.grade ? Json(grade_name(*verdict.grade)) : Json()},
          {"judgements", judgements},
          {"findings", findings}};
}

Json json_of(const NextViews& next, const CalibrationResult& result) {
  Json views = Json::array();
  for (const NextView& view : next.views) {
    Json outlines = Json::object();
    for (std::size_t c = 0; c < view.outlines.size(); ++c) {
      Json pixels = Json::array();
      for (const Eigen::Vector2d& pixel : view.outlines[c]) pixels.push_back({pixel.x(), pixel.y()});
      if (!pixels.empty()) outlines[result.calibration.cameras[c].name] = pixels;
    }
    views.push_back({{"camera", result.calibration.cameras[view.camera].name},
                     {"target", view.target},
                     {"text", view.text},
                     {"before", view.before},
                     {"after", view.after},
                     {"rig_from_target", json_from_pose(view.rig_from_target)},
                     {"outlines_px", outlines}});
  }
  return {{"objective", next.objective}, {"unit", next.quantity == Quantity::kDepth ? "m" : "px"}, {"views", views}};
}

// Four digits are more than a map shows.
Json rounded(double value) {
  return std::isfinite(value) ? Json(number_from<double>(fmt::format("{:.4g}", value)).value_or(value)) : Json();
}

// By the corners' noise or by how the frames scatter, whichever is larger.
UncertaintyMap larger_map(const RigCamera& camera, const Calibration& calibration, double range_m) {
  std::vector<ProjectionUncertainty> both{projection_uncertainty(camera, calibration.covariance)};
  if (calibration.covariance_by_frame) {
    both.push_back(projection_uncertainty(camera, *calibration.covariance_by_frame));
  }
  return uncertainty_map(both, range_m, kMapColumns);
}

Json json_of_maps(const std::vector<double>& ranges_m, const CalibrationResult& result) {
  Json maps = Json::array();
  for (const RigCamera& camera : result.calibration.cameras) {
    if (!camera.evidence) continue;
    for (const double range_m : ranges_m) {
      const UncertaintyMap map = larger_map(camera, result.calibration, range_m);
      Json rows = Json::array();
      for (Eigen::Index row = 0; row < map.sigma_px.rows(); ++row) {
        Json values = Json::array();
        for (const double sigma : map.sigma_px.row(row)) values.push_back(rounded(sigma));
        rows.push_back(values);
      }
      maps.push_back(
          {{"camera", camera.name}, {"range_m", std::isfinite(range_m) ? Json(range_m) : Json()}, {"sigma_px", rows}});
    }
  }
  return maps;
}

// How far each camera is from the first one, with the sigma that the terminal states, too.
Json json_of_baselines(const Calibration& calibration) {
  Json baselines = Json::array();
  for (std::size_t c = 1; c < calibration.cameras.size(); ++c) {
    const RigCamera& camera = calibration.cameras[c];
    baselines.push_back({{"camera", camera.name},
                         {"from", calibration.cameras.front().name},
                         {"length_m", camera.camera_from_rig.translation.norm()},
                         {"sigma_m", baseline_sigma(camera, calibration)}});
  }
  return baselines;
}

std::string next_views_text(const NextViews& next) {
  if (next.views.empty()) return {};
  std::string text = "next best views, by what they do to " + next.objective + ":\n";
  for (const NextView& view : next.views) {
    text += fmt::format("  {}: {} -> {}\n", view.text, text_with_unit(next.quantity, view.before),
                        text_with_unit(next.quantity, view.after));
  }
  return text;
}

}  // namespace

Judgements judge(const CalibrationProblem& problem, const CalibrationResult& result,
                 const std::vector<Requirement>& requirements, int threads) {
  Judgements judgements{verdict(problem, result, requirements), {}, {}};
  judgements.next_views = next_best_views(problem, result, worst_requirement(judgements.verdict), kNextViews, threads);
  std::vector<double>& ranges = judgements.ranges_m;
  const auto add = [&](double range_m) {
    if (std::ranges::find(ranges, range_m) == ranges.end()) ranges.push_back(range_m);
  };
  for (const Requirement& requirement : requirements) {
    if (requirement.quantity == Quantity::kProjection || requirement.quantity == Quantity::kDepth) {
      add(requirement.range_m);
    }
  }
  std::ranges::for_each(kUsualRanges_m, add);
  return judgements;
}

std::string text_of(const Judgements& judgements) {
  const Verdict& verdict = judgements.verdict;
  std::string text;
  for (const Judgement& each : verdict.judgements) {
    text += fmt::format("{:<8} {}: {}: {}\n", grade_name(each.grade), each.requirement.text, each.subject, each.reason);
    if (!each.advice.empty()) text += fmt::format("         {}\n", each.advice);
  }
  bool lacking = false;
  for (const Finding& each : verdict.findings) {
    if (each.good) continue;
    lacking = true;
    text += fmt::format("look at  {}: {}; {}\n", each.subject, each.text, each.advice);
  }
  const bool all_well = verdict.grade ? *verdict.grade == Grade::kPass : !lacking;
  return all_well ? text : text + next_views_text(judgements.next_views);
}

std::vector<ReportSection> sections_of(const Judgements& judgements, const CalibrationResult& result) {
  return {{"verdict", json_of(judgements.verdict).dump()},
          {"baselines", json_of_baselines(result.calibration).dump()},
          {"next_views", json_of(judgements.next_views, result).dump()},
          {"uncertainty_maps", json_of_maps(judgements.ranges_m, result).dump()}};
}

}  // namespace raybundle::apps
