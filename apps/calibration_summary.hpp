// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "raybundle/io/report_file.hpp"
#include "raybundle/scene/problem.hpp"
#include "raybundle/scene/result.hpp"

namespace raybundle::apps {

/// What the terminal says about a calibration: what was found, how good it is per camera, what was set aside and why,
/// and what to do next.
std::string summary_text(const CalibrationProblem& problem, const CalibrationResult& result,
                         const std::vector<UnusedImage>& unused);

}  // namespace raybundle::apps
