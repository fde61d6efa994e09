// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/io/report_file.hpp"

namespace raybundle::apps {

/// Checks of a calibration that take solves of their own, and are made only when asked for.
struct ExtraChecks {
  bool cross_validate = false;  ///< odd against even frames
  bool second_opinion = false;  ///< mrcal's solve of the same corners
};

/// What they found: sections of report.json, warnings, and lines for a person.
struct CheckFindings {
  std::vector<ReportSection> sections;
  std::vector<std::string> warnings;  ///< what speaks against the calibration
  std::string text;
};

CheckFindings run_extra_checks(const ExtraChecks& checks, const CalibrationProblem& problem,
                               const CalibrationResult& result, const CalibrateOptions& options);

}  // namespace raybundle::apps
