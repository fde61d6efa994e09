// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "raybundle/occupancy/monitor.hpp"

namespace raybundle::apps {

/// What is told of one frame: an entry of the `frames` of docs/formats/occupancy.md.
nlohmann::ordered_json json_of_answer(const std::string& file, const Occupancy& answer, const CaseBase& base);

/// The same in a row of a table.
std::vector<std::string> row_of_answer(const std::string& file, const Occupancy& answer, const CaseBase& base);
std::vector<std::string> head_of_answers();

}  // namespace raybundle::apps
