// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "raybundle/scene/problem.hpp"

namespace raybundle {

/// Names in the order in which they were first met, with their indices.
class NameList {
 public:
  /// Index of a name, which is added when it is new.
  int index_of(const std::string& name) {
    const auto [place, is_new] = indices_.try_emplace(name, static_cast<int>(names_.size()));
    if (is_new) names_.push_back(name);
    return place->second;
  }
  std::optional<int> find(const std::string& name) const {
    const auto found = indices_.find(name);
    return found == indices_.end() ? std::nullopt : std::optional(found->second);
  }
  bool contains(const std::string& name) const { return indices_.contains(name); }
  const std::vector<std::string>& names() const { return names_; }

 private:
  std::map<std::string, int> indices_;
  std::vector<std::string> names_;
};

/// check(), and that no two points of a view have the same pixel, with the name of the file in front of what they say.
void check_as_part_of(const std::string& file, const CalibrationProblem& problem);

}  // namespace raybundle
