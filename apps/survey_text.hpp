// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "raybundle/scene/result.hpp"

namespace raybundle::apps {

/// Root of the mean squared residual over all landmarks that were used; NaN without any [px].
double rms_px(const std::vector<SurveyImage>& images);

/// The images as docs/formats/survey.md has them.
nlohmann::ordered_json json_from_survey(const std::vector<SurveyImage>& images);

/// The same, with what the landmarks did to the cameras.
nlohmann::ordered_json json_from_survey(const SurveySummary& survey);

/// Every landmark in a table, then a line for each image.
std::string survey_table(const std::vector<SurveyImage>& images);

/// A line for each image: residuals, and whether they are as the sigmas say.
std::string survey_lines(const std::vector<SurveyImage>& images);

}  // namespace raybundle::apps
