// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>
#include <utility>
#include <vector>

#include "extra_checks.hpp"
#include "gates.hpp"
#include "input_flags.hpp"
#include "raybundle/scene/result.hpp"
#include "survey_input.hpp"

namespace raybundle::apps {

/// Everything that `calibrate` is told.
struct CalibrateJob {
  InputFlags input;
  CalibrateOptions options;
  std::set<std::string> options_given;  ///< names of those that override the dataset's
  std::vector<ParameterRule> rules;
  std::string start;  ///< a calibration.json whose values the cameras of the same names start from
  bool predict_corners = true;
  SurveyInput survey;  ///< landmarks for the bundle; without paths, those of the dataset
  GateFlags gates;
  ExtraChecks checks;
  std::string output = "calibration";  ///< folder
  bool json = false;
  std::string command;  ///< for the provenance
  std::string next;     ///< command to try next; empty: how to test the calibration on other images

  /// For the provenance: the flags that the results depend on, with their values.
  std::vector<std::pair<std::string, std::string>> flags_given;
};

/// From images or observations to calibration.json, report.json and report.html, with a summary on stdout.
///
/// @throws GateFailed when everything has been written, but a requirement is not met
void run_calibration(const CalibrateJob& job);

}  // namespace raybundle::apps
