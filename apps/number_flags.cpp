// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "number_flags.hpp"

#include <fmt/format.h>

#include <cmath>
#include <optional>

namespace raybundle::apps {
namespace {

std::optional<double> finite_from(const std::string& text) {
  double value = 0.0;
  if (!CLI::detail::lexical_cast(text, value) || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

std::string above_zero(const std::string& text) {
  const std::optional<double> value = finite_from(text);
  return value && *value > 0.0 ? "" : fmt::format("'{}' must be a number above 0", text);
}

std::string finite_number(const std::string& text) {
  return finite_from(text) ? "" : fmt::format("'{}' must be a number", text);
}

void refuse_endless_numbers(CLI::App& app) {
  for (CLI::Option* option : app.get_options()) {
    if (option->get_type_name().starts_with("FLOAT")) option->check(finite_number);
  }
  for (CLI::App* verb : app.get_subcommands([](CLI::App*) { return true; })) refuse_endless_numbers(*verb);
}

}  // namespace raybundle::apps
