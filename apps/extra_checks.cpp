// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "extra_checks.hpp"

#include <fmt/format.h>

#include "comparison_text.hpp"
#include "raybundle/calibrate/cross_validation.hpp"
#include "raybundle/uncertainty/second_opinion.hpp"

namespace raybundle::apps {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kVerdicts[] = {"agree", "agree_by_frames", "ties_disagree", "model_error",
                                     "too_few_frames"};  // as the enumeration

void add_cross_validation(const CalibrationProblem& problem, const CalibrationResult& result,
                          const CalibrateOptions& options, CheckFindings& findings) {
  const CrossValidation found = cross_validate(problem, result, options);
  Json trials = Json::array();
  for (const ModelTrial& trial : found.trials) {
    trials.push_back({{"camera", trial.camera},
                      {"model", trial.model},
                      {"share_within", trial.share_within},
                      {"rms_px", trial.rms_px},
                      {"agrees", trial.agrees}});
  }
  Json json{{"verdict", kVerdicts[static_cast<int>(found.verdict)]}, {"words", found.words}, {"trials", trials}};
  if (found.by_corners) json["by_corners"] = json_from_comparison(*found.by_corners);
  if (found.by_frames) json["by_frames"] = json_from_comparison(*found.by_frames);
  findings.sections.push_back({"cross_validation", json.dump()});
  findings.text += "cross-validation: " + found.words + "\n";
  using Verdict = CrossValidation::Verdict;
  if (found.verdict == Verdict::kModelError || found.verdict == Verdict::kTiesDisagree) {
    findings.warnings.push_back(found.words);
  }
}

Json json_from_opinion(const SecondOpinion& opinion) {
  if (!opinion.comparison) return {{"source", opinion.source}, {"why_not", opinion.why_not}};
  Json json{{"source", opinion.source},
            {"rms_px", opinion.rms_px},
            {"remark", opinion.remark},
            {"comparison", json_from_comparison(*opinion.comparison)}};
  if (opinion.approximation_px) json["approximation_px"] = *opinion.approximation_px;
  return json;
}

std::string text_of(const SecondOpinion& opinion) {
  if (!opinion.comparison) return fmt::format("none by {}: {}", opinion.source, opinion.why_not);
  std::string text = fmt::format("{}, rms {:.3f} px", opinion.source, opinion.rms_px);
  for (const ProjectionDifference& d : opinion.comparison->projections) {
    text += fmt::format("{} {} projects {:.4f} px apart rms, {:.4f} px at most",
                        &d == &opinion.comparison->projections[0] ? ":" : ",", d.camera, d.rms_px, d.largest_px);
  }
  return opinion.remark.empty() ? text : text + " (" + opinion.remark + ")";
}

void add_second_opinions(const CalibrationProblem& problem, const CalibrationResult& result, CheckFindings& findings) {
  Json json = Json::array();
  for (const SecondOpinion& opinion : second_opinions(problem, result)) {
    json.push_back(json_from_opinion(opinion));
    findings.text += "second opinion: " + text_of(opinion) + "\n";
  }
  findings.sections.push_back({"second_opinion", json.dump()});
}

}  // namespace

CheckFindings run_extra_checks(const ExtraChecks& checks, const CalibrationProblem& problem,
                               const CalibrationResult& result, const CalibrateOptions& options) {
  CheckFindings findings;
  if (checks.cross_validate) add_cross_validation(problem, result, options, findings);
  if (checks.second_opinion) add_second_opinions(problem, result, findings);
  return findings;
}

}  // namespace raybundle::apps
