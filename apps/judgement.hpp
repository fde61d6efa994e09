// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "raybundle/io/report_file.hpp"
#include "raybundle/uncertainty/next_view.hpp"
#include "raybundle/uncertainty/verdict.hpp"

namespace raybundle::apps {

/// A result held against requirements, with what to do next.
struct Judgements {
  Verdict verdict;
  NextViews next_views;
  std::vector<double> ranges_m;  ///< at which the page shows the uncertainty of projections, the required ones first
};

Judgements judge(const CalibrationProblem& problem, const CalibrationResult& result,
                 const std::vector<Requirement>& requirements, int threads);

/// What the terminal says: each requirement, what the data lack, and the next best views when one would help.
std::string text_of(const Judgements& judgements);

/// `verdict`, `baselines`, `next_views` and `uncertainty_maps` of report.json.
std::vector<ReportSection> sections_of(const Judgements& judgements, const CalibrationResult& result);

}  // namespace raybundle::apps
