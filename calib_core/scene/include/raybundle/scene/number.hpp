// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>

namespace raybundle {

/// The number that the whole text is, whatever the locale: with a point for decimals, perhaps a sign, and no blanks.
/// A text may also say inf or nan. Nothing when it is no number, or one that Number cannot hold.
template <typename Number>
std::optional<Number> number_from(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// The two numbers of a text like 11x9 or 320.5,240.
template <typename Number>
std::optional<std::array<Number, 2>> two_numbers_from(std::string_view text, char separator) {
  const std::size_t at = text.find(separator);
  if (at == std::string_view::npos) return std::nullopt;
  const auto first = number_from<Number>(text.substr(0, at)), second = number_from<Number>(text.substr(at + 1));
  if (!first || !second) return std::nullopt;
  return std::array<Number, 2>{*first, *second};
}

}  // namespace raybundle
