// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "raybundle/geometry/error.hpp"

namespace raybundle {

/// Appends values to the payload of a checked file, in this machine's byte order, without padding.
class ByteWriter {
 public:
  template <typename Value>
  void value(const Value& value) {
    static_assert(std::is_arithmetic_v<Value>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }

  /// Without their count.
  template <typename Value>
  void values(std::span<const Value> values) {
    static_assert(std::is_arithmetic_v<Value>);
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  }

  /// Its length, then its bytes.
  void text(std::string_view text) {
    value(static_cast<std::uint32_t>(text.size()));
    bytes_ += text;
  }

  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

/// Reads them back. Throws Error(kBadInput) where the bytes end too early or a number is out of its range.
class ByteReader {
 public:
  /// @param where   name of the file, for messages
  /// @param remake  for messages, how to make it again: FileKind::remake
  ByteReader(std::string_view bytes, std::string where, std::string_view remake)
      : bytes_(bytes), where_(std::move(where)), remake_(remake) {}

  template <typename Value>
  Value value() {
    static_assert(std::is_arithmetic_v<Value>);
    Value value;
    std::memcpy(&value, next(sizeof value), sizeof value);
    return value;
  }

  /// A whole number from `least` to `most`, stored as uint32.
  int count(int least, int most, const char* what) {
    const auto number = value<std::uint32_t>();
    if (number < static_cast<std::uint32_t>(least) || number > static_cast<std::uint32_t>(most)) fail(what);
    return static_cast<int>(number);
  }

  template <typename Value>
  std::vector<Value> values(std::size_t count) {
    static_assert(std::is_arithmetic_v<Value>);
    if (count > bytes_.size() / sizeof(Value)) fail("a list");
    std::vector<Value> values(count);
    if (count > 0) std::memcpy(values.data(), next(count * sizeof(Value)), count * sizeof(Value));
    return values;
  }

  std::string text() {
    const auto size = value<std::uint32_t>();
    if (size > bytes_.size()) fail("a text");
    return {next(size), size};
  }

  /// Nothing may follow.
  void expect_end() const {
    if (!bytes_.empty()) fail("the end");
  }

  [[noreturn]] void fail(const char* what) const {
    throw Error(ErrorKind::kBadInput,
                std::string("holds no sensible value for ") + what + "; make it again with `" + remake_ + "`", where_);
  }

 private:
  const char* next(std::size_t size) {
    if (size > bytes_.size()) fail("what follows its end");
    const char* at = bytes_.data();
    bytes_.remove_prefix(size);
    return at;
  }

  std::string_view bytes_;
  std::string where_, remake_;
};

}  // namespace raybundle
