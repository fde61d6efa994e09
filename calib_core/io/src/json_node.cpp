// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "json_node.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "image_side.hpp"
#include "json_location.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/csv.hpp"
#include "raybundle/scene/suggestion.hpp"

namespace raybundle {
namespace {

// Refuses an object that has a key twice: only one of the values could be meant. And finds where a long array and its
// entries stand. A pass of its own, because the parser's callback looks through a whole array behind each of its
// objects.
class FirstPass : public nlohmann::json_sax<nlohmann::json> {
 public:
  FirstPass(std::string_view text, std::string name, const std::string& long_key)
      : text_(text), furthest_(text.data()), name_(std::move(name)), long_key_(long_key) {
    nlohmann::json::sax_parse(CountingIterator(text.data(), &furthest_),
                              CountingIterator(text.data() + text.size(), &furthest_), this);
  }

  std::vector<std::string_view> entries;  // of the long array
  std::string_view inside;                // of its brackets
  bool all_objects = true;

  bool start_object(std::size_t) override {
    if (in_long_array()) entry_begin_ = taken() - 1;
    open_.push_back({false, {}});
    return true;
  }
  bool end_object() override {
    open_.pop_back();
    if (in_long_array()) entries.push_back(text_.substr(entry_begin_, taken() - entry_begin_));
    return true;
  }
  bool start_array(std::size_t) override {
    value();
    const bool is_long = open_.size() == 1 && !open_.back().array && last_key_ == long_key_ && !long_key_.empty();
    if (is_long) array_begin_ = taken();
    open_.push_back({true, {}});
    long_depth_ = is_long ? open_.size() : long_depth_;
    return true;
  }
  bool end_array() override {
    if (in_long_array()) {
      inside = text_.substr(array_begin_, taken() - 1 - array_begin_);
      long_depth_ = 0;
    }
    open_.pop_back();
    return true;
  }
  bool key(std::string& key) override {
    if (open_.size() == 1) last_key_ = key;
    if (open_.back().keys.insert(key).second) return true;
    throw Error(ErrorKind::kBadInput, "the key " + in_quotes(key) + " stands twice in one object; leave one out",
                name_);
  }
  bool null() override { return value(); }
  bool boolean(bool) override { return value(); }
  bool number_integer(number_integer_t) override { return value(); }
  bool number_unsigned(number_unsigned_t) override { return value(); }
  bool number_float(number_float_t, const std::string&) override { return value(); }
  bool string(std::string&) override { return value(); }
  bool binary(binary_t&) override { return value(); }
  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception&) override { return false; }

 private:
  struct Container {
    bool array;
    std::set<std::string> keys;
  };

  std::size_t taken() const { return static_cast<std::size_t>(furthest_ - text_.data()); }
  bool in_long_array() const { return long_depth_ > 0 && open_.size() == long_depth_; }
  // A value that is no object.
  bool value() {
    all_objects &= !in_long_array();
    return true;
  }

  std::string_view text_;
  const char* furthest_;
  std::string name_, long_key_, last_key_;
  std::vector<Container> open_;  // what has not ended, outermost first
  std::size_t long_depth_ = 0, array_begin_ = 0, entry_begin_ = 0;
};

nlohmann::json parsed(std::string_view text) { return nlohmann::json::parse(text.begin(), text.end()); }

[[noreturn]] void fail_syntax(std::string_view text, const std::string& name) {
  const std::size_t byte = byte_of_syntax_error(text);
  const std::string where = name + ":" + std::to_string(line_of_byte(text, byte));
  if (byte >= text.size()) {
    throw Error(ErrorKind::kBadInput, "the JSON text ends too early; is the file complete?", where);
  }
  if (text.find('\0') != std::string_view::npos) {  // nothing of it can be shown
    throw Error(ErrorKind::kBadInput, "this is not JSON, and no text at all, as an image is; is it the right file?",
                where);
  }
  const std::size_t begin = byte - std::min<std::size_t>(byte, 20);
  throw Error(ErrorKind::kBadInput,
              "this is not valid JSON, the mistake is at the end of " +
                  in_quotes(text.substr(begin, byte + 1 - begin)) + "; correct it or write the file again",
              where);
}

}  // namespace

JsonDocument parse_json(std::string_view text, const std::string& name, LongJsonArray* long_array) {
  try {
    FirstPass first(text, name, long_array ? long_array->key : "");
    const bool long_one = long_array && first.inside.data() != nullptr;  // an array that ends
    if (!long_one || first.entries.empty() || !first.all_objects) return {text, name, parsed(text)};
    std::string rest(text.substr(0, static_cast<std::size_t>(first.inside.data() - text.data())));
    rest += std::string_view(first.inside.data() + first.inside.size(), text.data() + text.size());
    JsonDocument document{text, name, parsed(rest)};
    long_array->entries = std::move(first.entries);
    return document;
  } catch (const nlohmann::json::exception&) {
    fail_syntax(text, name);
  }
}

JsonNode JsonNode::at(std::string_view key) const& {
  const std::optional<JsonNode> found = find(key);
  if (found) return *found;
  JsonNode missing;
  missing.document_ = document_;
  missing.value_ = value_;
  missing.parent_ = this;
  missing.key_ = key;
  missing.fail("is missing; add it");
}

std::optional<JsonNode> JsonNode::find(std::string_view key) const& {
  if (!value_->is_object()) fail_type("an object");
  const auto found = value_->find(key);
  if (found == value_->end()) return std::nullopt;
  JsonNode node;
  node.document_ = document_;
  node.value_ = &*found;
  node.parent_ = this;
  node.key_ = key;
  return node;
}

JsonNode JsonNode::operator[](std::size_t index) const& { return entry(index, value_->at(index)); }

JsonNode JsonNode::entry(std::size_t index, const nlohmann::json& value) const& {
  JsonNode node;
  node.document_ = document_;
  node.value_ = &value;
  node.parent_ = this;
  node.index_ = index;
  return node;
}

std::size_t JsonNode::array_size() const {
  if (!value_->is_array()) fail_type("an array");
  return value_->size();
}

void JsonNode::expect_array_size(std::size_t size) const {
  if (array_size() == size) return;
  fail("has " + std::to_string(value_->size()) + " entries where " + std::to_string(size) +
       " are expected; correct it or write the file again");
}

std::vector<std::string> JsonNode::keys() const {
  if (!value_->is_object()) fail_type("an object");
  std::vector<std::string> keys;
  for (const auto& item : value_->items()) keys.push_back(item.key());
  return keys;
}

void JsonNode::expect_keys(const std::vector<std::string>& known) const {
  for (const std::string& key : keys()) {
    if (std::ranges::find(known, key) != known.end()) continue;
    find(key)->fail("is not a key that belongs here." + did_you_mean(key, known));
  }
}

double JsonNode::number() const {
  if (!value_->is_number()) fail_type("a number");
  return value_->get<double>();  // JSON has no NaN, and the parser refuses what overflows
}

double JsonNode::positive_number() const {
  const double value = number();
  if (!(value > 0)) fail("is " + value_->dump() + "; it must be positive");
  return value;
}

int JsonNode::whole_number(int low, int high) const {
  const std::string range = "a whole number from " + std::to_string(low) + " to " + std::to_string(high);
  if (!value_->is_number_integer()) fail_type(range.c_str());
  const bool too_large = value_->is_number_unsigned() && value_->get<std::uint64_t>() > static_cast<unsigned>(high);
  if (too_large || value_->get<std::int64_t>() < low || value_->get<std::int64_t>() > high) {
    fail("is " + value_->dump() + "; it must be " + range);
  }
  return value_->get<int>();
}

bool JsonNode::boolean() const {
  if (!value_->is_boolean()) fail_type("true or false");
  return value_->get<bool>();
}

std::string JsonNode::text() const {
  if (!value_->is_string()) fail_type("a text in quotes");
  return value_->get<std::string>();
}

std::string JsonNode::name() const {
  std::string value = text();
  if (value.empty()) fail("is empty; give it a name");
  return value;
}

ModelId JsonNode::model() const {
  const std::string value = text();
  if (const auto model = model_named(value)) return *model;
  const std::vector<std::string_view> names = model_names();
  fail(in_quotes(value) + " is not a camera model that this version knows." +
       did_you_mean(value, {names.begin(), names.end()}));
}

ImageSize JsonNode::image_size() const {
  return {at("width").whole_number(1, kMaxImageSide_px), at("height").whole_number(1, kMaxImageSide_px)};
}

Rigid3 JsonNode::rigid3() const {
  const JsonNode rotation = at("rotation_xyzw");
  const Eigen::Vector3d translation = at("translation_m").vector<3>();
  return {unit_quaternion(rotation, Eigen::Quaterniond(rotation.vector<4>())),
          translation};  // Eigen's order is x y z w
}

Eigen::Quaterniond unit_quaternion(const JsonNode& node, Eigen::Quaterniond quaternion) {
  const double norm = quaternion.norm();
  if (!(std::abs(norm - 1.0) < 1e-3)) {
    node.fail("is not a unit quaternion (its length is " + std::to_string(norm) + "); correct it");
  }
  // One that was written with a few digits is mended; one that we wrote keeps its bits.
  if (std::abs(norm - 1.0) > 1e-12) quaternion.normalize();
  return quaternion;
}

std::string JsonNode::path() const {
  if (parent_ == nullptr) return "";
  const std::string before = parent_->path();
  if (key_.data() == nullptr) return before + "[" + std::to_string(index_) + "]";
  return before.empty() ? std::string(key_) : before + "." + std::string(key_);
}

int JsonNode::line() const {
  std::vector<JsonStep> steps;
  const nlohmann::json* missing_from = parent_ != nullptr && parent_->value_ == value_ ? value_ : nullptr;
  for (const JsonNode* node = missing_from ? parent_ : this; node->parent_ != nullptr; node = node->parent_) {
    steps.push_back({node->key_, node->index_, node->key_.data() == nullptr});
  }
  std::ranges::reverse(steps);
  return line_of_value(document_->text, steps);
}

void JsonNode::fail(const std::string& message) const {
  const std::string subject = parent_ == nullptr ? "the whole text" : path();
  throw Error(ErrorKind::kBadInput, subject + " " + message, document_->name + ":" + std::to_string(line()));
}

void JsonNode::fail_type(const char* wanted) const {
  const char* found = value_->is_null()      ? "null"
                      : value_->is_string()  ? "a text"
                      : value_->is_array()   ? "an array"
                      : value_->is_object()  ? "an object"
                      : value_->is_boolean() ? "true or false"
                                             : "a number";
  fail("is " + std::string(found) + ", where " + wanted + " is expected; correct it");
}

void expect_format(const JsonNode& root, const std::string& format, int version) {
  const JsonNode format_node = root.at("format");
  if (format_node.text() != format) {
    format_node.fail("is " + in_quotes(format_node.text()) + " where " + in_quotes(format) +
                     " is expected; is this the right file?");
  }
  const JsonNode version_node = root.at("version");
  const int found = version_node.whole_number(0, 1'000'000);
  if (found != version) {
    version_node.fail("is " + std::to_string(found) + ", and this program reads version " + std::to_string(version) +
                      "; write the file again with this program, or read it with the one that wrote it");
  }
}

}  // namespace raybundle
