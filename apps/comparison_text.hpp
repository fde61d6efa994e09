// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "raybundle/uncertainty/comparison.hpp"

namespace raybundle::apps {

/// Everything of a comparison, as docs/formats/comparison.md says.
nlohmann::ordered_json json_from_comparison(const CalibrationComparison& comparison);

/// What a person wants to know of it, in lines.
std::string comparison_text(const CalibrationComparison& comparison);

/// `at 0.5 m`, `at infinity`.
std::string range_text(double range_m);

/// What one of the lenses does not see, in words; empty: nothing.
std::string lost_text(const ProjectionDifference& difference);

}  // namespace raybundle::apps
