// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/requirements.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <span>

#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/number.hpp"
#include "raybundle/scene/suggestion.hpp"

namespace raybundle {
namespace {

struct Unit {
  std::string_view name;
  double factor;
};

constexpr std::array kPixels{Unit{"px", 1.0}, Unit{"pixel", 1.0}, Unit{"pixels", 1.0}};
constexpr std::array kLengths{Unit{"mm", 1e-3}, Unit{"cm", 1e-2}, Unit{"m", 1.0}, Unit{"um", 1e-6}, Unit{"µm", 1e-6}};
constexpr std::array kShares{Unit{"%", 0.01}, Unit{"percent", 0.01}};
constexpr std::array kAngles{Unit{"deg", M_PI / 180}, Unit{"degree", M_PI / 180}, Unit{"degrees", M_PI / 180},
                             Unit{"°", M_PI / 180}};

// What may follow a quantity.
struct Grammar {
  Quantity quantity;
  std::string_view name;
  std::span<const Unit> units;
  bool needs_range;
  bool may_have_range;
  bool may_have_field;
  std::string_view example;
};

constexpr std::array kGrammars{
    Grammar{Quantity::kProjection, "projection", kPixels, false, true, true, "projection 0.2 px at 1 m over 110 deg"},
    Grammar{Quantity::kDepth, "depth", kLengths, true, true, true, "depth 20 mm at 1 m"},
    Grammar{Quantity::kBaseline, "baseline", kLengths, false, false, false, "baseline 0.1 mm"},
    Grammar{Quantity::kRms, "rms", kPixels, false, false, false, "rms 0.3 px"},
    Grammar{Quantity::kCoverage, "coverage", kShares, false, false, false, "coverage 80 %"}};

template <typename Units>
std::string names_of(const Units& units) {
  std::string names;
  for (const auto& unit : units) names += (names.empty() ? "" : ", ") + std::string(unit.name);
  return names;
}

// A requirement word by word; a number and the unit that is written against it are two words.
class Words {
 public:
  explicit Words(std::string_view text) : text_(text) {
    const auto numeric = [](char c) { return (c >= '0' && c <= '9') || c == '.'; };
    for (std::size_t i = 0; i < text.size();) {
      if (std::isspace(static_cast<unsigned char>(text[i]))) {
        ++i;
        continue;
      }
      const std::size_t begin = i;
      const bool number = numeric(text[i]);
      while (i < text.size() && !std::isspace(static_cast<unsigned char>(text[i])) &&
             !(number && !numeric(text[i]) && !is_exponent(i))) {
        ++i;
      }
      words_.emplace_back(text.substr(begin, i - begin));
    }
  }

  bool done() const { return next_ == words_.size(); }
  std::string peek() const { return done() ? std::string() : words_[next_]; }
  std::string take() { return done() ? std::string() : words_[next_++]; }
  bool take(std::string_view word) {
    if (peek() != word) return false;
    ++next_;
    return true;
  }

  [[noreturn]] void fail(const std::string& message) const {
    throw Error(ErrorKind::kBadInput, fmt::format("the requirement '{}' is not understood: {}", text_, message));
  }

  // A positive number and its unit, in SI.
  double quantity(std::string_view what, std::span<const Unit> units, std::string_view example) {
    const std::string number = take();
    const double value = number_from<double>(number).value_or(0.0);
    if (!(value > 0) || !std::isfinite(value)) {
      fail(fmt::format("{} wants a number above zero, not '{}', as in '{}'", what, number, example));
    }
    const std::string unit = take();
    for (const Unit& each : units) {
      if (unit == each.name) return value * each.factor;
    }
    fail(fmt::format("{} is stated in {}, not '{}', as in '{}'", what, names_of(units), unit, example));
  }

 private:
  // The e of 1e-3, and the sign after it; not the letter of a unit.
  bool is_exponent(std::size_t i) const {
    const auto digit = [&](std::size_t k) { return k < text_.size() && text_[k] >= '0' && text_[k] <= '9'; };
    if (text_[i] == 'e') return digit(i + 1) || (i + 1 < text_.size() && text_[i + 1] == '-' && digit(i + 2));
    return text_[i] == '-' && i > 0 && text_[i - 1] == 'e';
  }

  std::string_view text_;
  std::vector<std::string> words_;
  std::size_t next_ = 0;
};

const Grammar& grammar_of(Words& words) {
  const std::string name = words.take();
  std::vector<std::string> known;
  for (const Grammar& grammar : kGrammars) {
    if (name == grammar.name) return grammar;
    known.emplace_back(grammar.name);
  }
  if (name.empty()) words.fail("it is empty; write for instance 'projection 0.2 px over 110 deg'");
  words.fail(fmt::format("'{}' is nothing that can be required.{}", name, did_you_mean(name, known)));
}

}  // namespace

std::string requirement_help() {
  std::string text;
  for (const Grammar& grammar : kGrammars) text += (text.empty() ? "" : ", ") + fmt::format("'{}'", grammar.example);
  return text + "; each may end in 'for CAMERA'";
}

Requirement requirement_from_text(std::string_view text) {
  Words words(text);
  const Grammar& grammar = grammar_of(words);
  Requirement requirement{.text = std::string(text), .quantity = grammar.quantity};
  requirement.limit = words.quantity(grammar.name, grammar.units, grammar.example);
  bool has_range = false;
  std::vector<std::string> said;
  while (!words.done()) {
    const std::string word = words.take();
    if (std::ranges::find(said, word) != said.end()) {
      words.fail(fmt::format("'{}' stands twice; write a requirement for each", word));
    }
    said.push_back(word);
    if (word == "at" && grammar.may_have_range) {
      has_range = true;
      if (!words.take("infinity")) requirement.range_m = words.quantity("a distance", kLengths, grammar.example);
    } else if (word == "over" && grammar.may_have_field) {
      requirement.field_rad = words.quantity("an angle", kAngles, "projection 0.2 px over 110 deg");
    } else if (word == "for" && !words.done()) {
      requirement.camera = words.take();
    } else {
      words.fail(fmt::format("'{}' cannot follow {}; write it as '{}', with 'for CAMERA' when one camera is meant",
                             word, grammar.name, grammar.example));
    }
  }
  if (grammar.needs_range && !has_range) {
    words.fail(fmt::format("{} depends on the distance; say at which, as in '{}'", grammar.name, grammar.example));
  }
  if (grammar.quantity == Quantity::kDepth && !std::isfinite(requirement.range_m)) {
    words.fail("nothing tells the depth of what is infinitely far");
  }
  return requirement;
}

std::string text_with_unit(Quantity quantity, double value) {
  switch (quantity) {
    case Quantity::kRms:
    case Quantity::kProjection:
      return fmt::format("{:.{}f} px", value, value < 0.01 ? 4 : value < 0.1 ? 3 : 2);
    case Quantity::kDepth:
    case Quantity::kBaseline:
      return fmt::format("{:.{}f} mm", 1e3 * value, value < 1e-3 ? 3 : value < 0.1 ? 2 : 0);
    case Quantity::kCoverage:
      return fmt::format("{:.0f} %", 100 * value);
  }
  return {};
}

}  // namespace raybundle
