// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/App.hpp>
#include <string>
#include <vector>

#include "raybundle/scene/survey.hpp"

namespace raybundle::apps {

/// Where landmarks and their sightings stand, and what the tables do not say.
struct SurveyInput {
  std::string landmarks, sightings;  ///< paths of CSV files
  std::string height;                ///< words of height_datum_from_word(); may be empty
  std::vector<double> origin;        ///< latitude, longitude [deg], height above the ellipsoid [m]; may be empty
  double sigma_px = 0.5;             ///< of a sighting's u and v
};

/// Declares --landmarks, --sightings, --origin, --height and --sighting-sigma.
void add_survey_flags(CLI::App& verb, bool required, SurveyInput& input);

/// @throws Error naming the file and line, or the flag that is missing
Survey read_survey(const SurveyInput& input);

}  // namespace raybundle::apps
