// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "json_location.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace raybundle {
namespace {

using Json = nlohmann::json;

// Follows a path of keys and indices; stops the parser at its end, or at a syntax error.
class Locator : public nlohmann::json_sax<Json> {
 public:
  explicit Locator(const std::vector<JsonStep>& path) : path_(path) {}
  std::size_t error_byte = 0;

  bool null() override { return scalar(); }
  bool boolean(bool) override { return scalar(); }
  bool number_integer(number_integer_t) override { return scalar(); }
  bool number_unsigned(number_unsigned_t) override { return scalar(); }
  bool number_float(number_float_t, const string_t&) override { return scalar(); }
  bool string(string_t&) override { return scalar(); }
  bool binary(binary_t&) override { return scalar(); }
  bool start_object(std::size_t) override { return container(); }
  bool start_array(std::size_t) override { return container(); }
  bool end_object() override { return leave(); }
  bool end_array() override { return leave(); }
  bool key(string_t& name) override {
    on_path_ = matched_ + 1 == depth_ && !path_[matched_].in_array && path_[matched_].key == name;
    return true;
  }
  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception&) override {
    error_byte = position;
    return false;
  }

 private:
  // A value begins. True to go on: it is not the end of the path.
  bool begin() {
    if (depth_ == 0) return !path_.empty();
    if (matched_ + 1 == depth_ && path_[matched_].in_array) on_path_ = path_[matched_].index == next_index_++;
    return !on_path_ || matched_ + 1 != path_.size();
  }
  bool scalar() {
    const bool more = begin();
    on_path_ = false;
    return more;
  }
  bool container() {
    if (!begin()) return false;
    if (on_path_) {
      ++matched_;
      next_index_ = 0;
    }
    on_path_ = false;
    ++depth_;
    return true;
  }
  bool leave() {
    --depth_;
    return true;
  }

  const std::vector<JsonStep>& path_;
  std::size_t depth_ = 0;       // containers that are open
  std::size_t matched_ = 0;     // steps of the path that have been taken
  std::size_t next_index_ = 0;  // in the array that the path has reached
  bool on_path_ = false;        // the value that begins next, or has just begun, is the path's next step
};

}  // namespace

int line_of_byte(std::string_view text, std::size_t byte) {
  return 1 + static_cast<int>(std::ranges::count(text.substr(0, byte), '\n'));
}

std::size_t byte_of_syntax_error(std::string_view text) {
  const std::vector<JsonStep> nowhere(1, JsonStep{{}, text.size(), true});
  Locator locator(nowhere);
  Json::sax_parse(text.begin(), text.end(), &locator);
  return locator.error_byte == 0 ? 0 : locator.error_byte - 1;
}

int line_of_value(std::string_view text, const std::vector<JsonStep>& path) {
  Locator locator(path);
  const char* furthest = text.data();
  Json::sax_parse(CountingIterator(text.data(), &furthest), CountingIterator(text.data() + text.size(), &furthest),
                  &locator);
  // The parser has looked one byte beyond a number; that byte may be the end of the line.
  const auto taken = static_cast<std::size_t>(furthest - text.data());
  return line_of_byte(text, taken == 0 ? 0 : taken - 1);
}

}  // namespace raybundle
