// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace raybundle {

/// The candidate that was probably meant by a misspelt word; nothing when none is near.
///
/// Near: fewer than half of the letters have to be changed, added, dropped or swapped with their neighbour; upper and
/// lower case count as the same. The first of equally near candidates wins.
std::optional<std::string> closest(const std::string& word, const std::vector<std::string>& candidates);

/// The end of a message about an unknown word: ` Did you mean "square_m"?`, or ` Known: a, b, c.` when none is near.
std::string did_you_mean(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace raybundle
