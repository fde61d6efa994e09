// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <iterator>
#include <string_view>
#include <vector>

namespace raybundle {

/// Walks a text and reports how far the parser has come: up to one byte beyond a number, exactly behind a bracket.
class CountingIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  CountingIterator(const char* place, const char** furthest) : place_(place), furthest_(furthest) {}
  reference operator*() const { return *place_; }
  CountingIterator& operator++() {
    *furthest_ = ++place_;
    return *this;
  }
  bool operator==(const CountingIterator& other) const { return place_ == other.place_; }
  bool operator!=(const CountingIterator& other) const { return place_ != other.place_; }

 private:
  const char* place_;
  const char** furthest_;
};

/// Line, from 1, of a byte in a text.
int line_of_byte(std::string_view text, std::size_t byte);

/// Byte at which the parser gave up; nothing is assumed about why.
std::size_t byte_of_syntax_error(std::string_view text);

/// A step from a value into a part of it.
struct JsonStep {
  std::string_view key;   ///< of an object
  std::size_t index = 0;  ///< in an array
  bool in_array = false;
};

/// Line on which the value at the end of a path begins, in a text that has been parsed.
int line_of_value(std::string_view text, const std::vector<JsonStep>& path);

}  // namespace raybundle
