// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/App.hpp>
#include <string>

namespace raybundle::apps {

/// What is wrong with a command line, in one sentence that says what was probably meant.
std::string usage_message(const CLI::App& app, const CLI::ParseError& error);

}  // namespace raybundle::apps
