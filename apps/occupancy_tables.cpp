// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "occupancy_evaluation.hpp"
#include "terminal.hpp"

namespace raybundle::apps {
namespace {

std::string percent(const Share& share) {
  return fmt::format("{:.2f} % ({:.2f} to {:.2f})", 100 * share.value(), 100 * share.low(), 100 * share.high());
}

// Rows are the truth.
template <typename Confusion, typename Names>
std::string confusion_table(const char* title, const Confusion& confusion, const Names& names, const char* none) {
  std::vector<std::vector<std::string>> rows{{title}};
  for (const std::string_view name : names) rows[0].emplace_back(name);
  rows[0].emplace_back(none);
  for (std::size_t truth = 0; truth < confusion.size(); ++truth) {
    rows.push_back({std::string(names[truth])});
    for (const int count : confusion[truth]) rows.back().push_back(fmt::format("{}", count));
  }
  return text_table(rows);
}

double within(const std::vector<double>& errors_m, double bound_m) {
  int count = 0;
  for (const double error : errors_m) count += std::abs(error) <= bound_m;
  return errors_m.empty() ? 0.0 : static_cast<double>(count) / static_cast<double>(errors_m.size());
}

std::string distances_text(const char* what, const std::vector<double>& errors_m) {
  if (errors_m.empty()) return {};
  return fmt::format("{}: {} scenes, {:.1f} % within 20 mm, median {:.1f} mm, largest {:.1f} mm\n", what,
                     errors_m.size(), 100 * within(errors_m, 0.02), 1e3 * std::abs(errors_m[errors_m.size() / 2]),
                     1e3 * std::abs(errors_m.back()));
}

nlohmann::ordered_json json_of(const Share& share) {
  return {{"count", share.count},
          {"trials", share.trials},
          {"share", share.value()},
          {"low_95", share.low()},
          {"high_95", share.high()}};
}

nlohmann::ordered_json json_of(const std::vector<double>& errors_m) {
  nlohmann::ordered_json json{{"count", errors_m.size()}};
  if (errors_m.empty()) return json;
  json["within_20_mm"] = within(errors_m, 0.02);
  json["median_m"] = std::abs(errors_m[errors_m.size() / 2]);
  json["largest_m"] = std::abs(errors_m.back());
  return json;
}

}  // namespace

std::string text_from_evaluation(const std::string& title, const Evaluation& e) {
  std::string text = fmt::format("{}: {} scenes\n\n", title, e.scenes);
  text += confusion_table("class", e.classes, kCabinClassNames, "unknown") + "\n";
  text += confusion_table("group", e.groups, kCabinGroupNames, "unsure") + "\n";
  text += confusion_table("airbag", e.actions, kCabinDecisionNames, "undecided") + "\n";
  text +=
      fmt::format("8 classes right: {} of answers; no answer: {}\n", percent(e.right_class), percent(e.rejected_class));
  text +=
      fmt::format("3 groups right:  {} of answers; no answer: {}\n", percent(e.right_group), percent(e.rejected_group));
  text += fmt::format("decision right:  {} of answers; undecided: {}\n", percent(e.right_action),
                      percent(e.rejected_action));
  text += fmt::format("dangerous (more forceful than right, somebody there): {} of {}: {}\n", e.dangerous.count,
                      e.dangerous.trials, percent(e.dangerous));
  text += fmt::format("fired for nobody: {}\n", percent(e.wasted));
  text += distances_text("distance to the dashboard, of the dot told", e.distance_errors_m);
  if (e.nearer_missed.trials > 0) text += fmt::format("a dot 20 mm nearer not told: {}\n", percent(e.nearer_missed));
  text += distances_text("distance to the dashboard, of the nearest place seen or not", e.nearest_errors_m);
  return text;
}

std::string json_from_evaluations(const std::vector<std::pair<std::string, Evaluation>>& evaluations) {
  nlohmann::ordered_json splits = nlohmann::ordered_json::array();
  for (const auto& [name, e] : evaluations) {
    splits.push_back({{"name", name},
                      {"scenes", e.scenes},
                      {"classes", e.classes},
                      {"groups", e.groups},
                      {"actions", e.actions},
                      {"right_class", json_of(e.right_class)},
                      {"right_group", json_of(e.right_group)},
                      {"right_action", json_of(e.right_action)},
                      {"rejected_class", json_of(e.rejected_class)},
                      {"rejected_group", json_of(e.rejected_group)},
                      {"rejected_action", json_of(e.rejected_action)},
                      {"dangerous", json_of(e.dangerous)},
                      {"wasted", json_of(e.wasted)},
                      {"distance", json_of(e.distance_errors_m)},
                      {"nearer_missed", json_of(e.nearer_missed)},
                      {"distance_unseen", json_of(e.nearest_errors_m)}});
  }
  return nlohmann::ordered_json{{"splits", splits}}.dump(2);
}

}  // namespace raybundle::apps
