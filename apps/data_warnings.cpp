// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "data_warnings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace raybundle::apps {
namespace {

constexpr double kWidestSpacing_m = 1.0;      // boards are carried by hand
constexpr double kNarrowestSpacing_m = 2e-4;  // and their points are told apart by eye
constexpr int kFewViews = 8;

// Median distance from a point to its nearest neighbour [m].
double spacing_m(const Target& target) {
  std::vector<double> nearest;
  for (const TargetPoint& point : target.points) {
    double distance = std::numeric_limits<double>::infinity();
    for (const TargetPoint& other : target.points) {
      if (other.id != point.id) distance = std::min(distance, (other.x_in_target - point.x_in_target).norm());
    }
    nearest.push_back(distance);
  }
  if (nearest.empty()) return 0.0;
  const auto middle = nearest.begin() + static_cast<std::ptrdiff_t>(nearest.size() / 2);
  std::nth_element(nearest.begin(), middle, nearest.end());
  return *middle;
}

}  // namespace

std::string unit_warning(const Target& target) {
  const double spacing = spacing_m(target);
  if (spacing >= kNarrowestSpacing_m && spacing <= kWidestSpacing_m) return {};
  return fmt::format(
      "the points of {} lie {:.6g} m apart: is the unit right (25mm in a word, 0.025 in square_m)? The baseline and "
      "the "
      "poses are wrong by the same factor as the board",
      target.name, spacing);
}

std::vector<std::string> data_warnings(const CalibrationProblem& problem, const CalibrationResult& result) {
  std::vector<std::string> warnings;
  for (const Target& target : problem.targets) {
    if (const std::string warning = unit_warning(target); !warning.empty()) warnings.push_back(warning);
  }
  for (std::size_t c = 0; c < problem.cameras.size(); ++c) {
    const int views = result.cameras[c].views_used;
    if (views == 0 || views >= kFewViews) continue;
    warnings.push_back(fmt::format(
        "camera {} stands on {} views only, too few to show what the lens does in the whole image: the sigmas hold for "
        "this model, but nothing tests the model; take 15 to 30, near and far, tilted, and into every corner",
        problem.cameras[c].name, views));
  }
  return warnings;
}

}  // namespace raybundle::apps
