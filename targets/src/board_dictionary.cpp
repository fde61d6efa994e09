// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "board_dictionary.hpp"

#include <array>
#include <span>
#include <utility>

#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/suggestion.hpp"

namespace raybundle {
namespace {

using NamedDictionary = std::pair<const char*, cv::aruco::PREDEFINED_DICTIONARY_NAME>;

constexpr auto kDictionaries = std::to_array<NamedDictionary>({
    {"DICT_4X4_50", cv::aruco::DICT_4X4_50},
    {"DICT_4X4_100", cv::aruco::DICT_4X4_100},
    {"DICT_4X4_250", cv::aruco::DICT_4X4_250},
    {"DICT_4X4_1000", cv::aruco::DICT_4X4_1000},
    {"DICT_5X5_50", cv::aruco::DICT_5X5_50},
    {"DICT_5X5_100", cv::aruco::DICT_5X5_100},
    {"DICT_5X5_250", cv::aruco::DICT_5X5_250},
    {"DICT_5X5_1000", cv::aruco::DICT_5X5_1000},
    {"DICT_6X6_50", cv::aruco::DICT_6X6_50},
    {"DICT_6X6_100", cv::aruco::DICT_6X6_100},
    {"DICT_6X6_250", cv::aruco::DICT_6X6_250},
    {"DICT_6X6_1000", cv::aruco::DICT_6X6_1000},
    {"DICT_7X7_50", cv::aruco::DICT_7X7_50},
    {"DICT_7X7_100", cv::aruco::DICT_7X7_100},
    {"DICT_7X7_250", cv::aruco::DICT_7X7_250},
    {"DICT_7X7_1000", cv::aruco::DICT_7X7_1000},
    {"DICT_ARUCO_ORIGINAL", cv::aruco::DICT_ARUCO_ORIGINAL},
    {"DICT_APRILTAG_16h5", cv::aruco::DICT_APRILTAG_16h5},
    {"DICT_APRILTAG_25h9", cv::aruco::DICT_APRILTAG_25h9},
    {"DICT_APRILTAG_36h10", cv::aruco::DICT_APRILTAG_36h10},
    {"DICT_APRILTAG_36h11", cv::aruco::DICT_APRILTAG_36h11},
});

constexpr auto kFamilies = std::to_array<NamedDictionary>({
    {"36h11", cv::aruco::DICT_APRILTAG_36h11},
    {"25h9", cv::aruco::DICT_APRILTAG_25h9},
    {"16h5", cv::aruco::DICT_APRILTAG_16h5},
});

void add_names(std::span<const NamedDictionary> list, std::vector<std::string>& names) {
  for (const NamedDictionary& entry : list) names.emplace_back(entry.first);
}

// Null when there is none of that name.
cv::Ptr<cv::aruco::Dictionary> find(std::span<const NamedDictionary> list, const std::string& name) {
  for (const NamedDictionary& entry : list) {
    if (name == entry.first) return cv::aruco::getPredefinedDictionary(entry.second);
  }
  return nullptr;
}

[[noreturn]] void refuse(const std::string& what, const std::string& name, const std::vector<std::string>& known) {
  throw Error(ErrorKind::kBadInput, "there is no " + what + " \"" + name + "\"." + did_you_mean(name, known));
}

}  // namespace

std::vector<std::string> dictionary_names() {
  std::vector<std::string> names;
  add_names(kDictionaries, names);
  return names;
}

std::vector<std::string> tag_family_names() {
  std::vector<std::string> names;
  add_names(kFamilies, names);
  add_names(kDictionaries, names);
  return names;
}

cv::Ptr<cv::aruco::Dictionary> dictionary_named(const std::string& name) {
  if (const auto found = find(kDictionaries, name)) return found;
  refuse("marker dictionary", name, dictionary_names());
}

cv::Ptr<cv::aruco::Dictionary> tag_family_named(const std::string& family) {
  if (const auto found = find(kFamilies, family)) return found;
  if (const auto found = find(kDictionaries, family)) return found;
  refuse("tag family", family, tag_family_names());
}

}  // namespace raybundle
