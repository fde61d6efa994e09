// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace raybundle {

/// Whether a text matches a pattern with * (any characters) and ? (one character).
bool matches_pattern(std::string_view text, std::string_view pattern);

}  // namespace raybundle
