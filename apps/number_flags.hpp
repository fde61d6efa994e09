// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/App.hpp>
#include <cstdint>
#include <string>

namespace raybundle::apps {

inline constexpr std::uint64_t kMostSeed = 1'000'000'000'000;  ///< of what is simulated

/// For CLI::Option::check(): what is wrong with a value that is no number above 0; empty when nothing is.
std::string above_zero(const std::string& text);

/// For CLI::Option::check(): what is wrong with a value that is no number, or not a finite one; empty when nothing is.
std::string finite_number(const std::string& text);

/// Lets no flag of any verb that takes real numbers accept NaN or infinity, which pass CLI::Range. Flags whose value
/// has a type_name() of its own check for themselves.
void refuse_endless_numbers(CLI::App& app);

}  // namespace raybundle::apps
