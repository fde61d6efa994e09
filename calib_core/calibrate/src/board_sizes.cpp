// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "board_sizes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/quantile.hpp"

namespace raybundle {
namespace {

constexpr double kLargestTurn_rad = 0.02;     // between the cameras, by a frame and by the rig
constexpr double kLargestSlant_rad = 0.05;    // between the two directions from camera to camera
constexpr double kSmallestDifference = 0.05;  // of a size: boards that moved between exposures seem to differ too,
constexpr double kLargestScatter = 0.01;      // but not by one factor in all frames
constexpr std::size_t kFewestFrames = 3;

// What a frame that does not fit the rig would make of the distance between two cameras.
struct OtherDistance {
  int frame;
  double factor;
};

// Those frames of two cameras that differ from the rig in nothing but the distance between the two.
std::vector<OtherDistance> other_distances(const CalibrationProblem& problem, const BundleState& state, int first,
                                           int second) {
  std::map<std::pair<int, int>, std::size_t> views_of_first;  // by frame and target
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    const TargetView& view = problem.views[v];
    if (view.camera == first && state.pose_of_view[v] >= 0) views_of_first[{view.frame, view.target}] = v;
  }
  const Rigid3 by_rig = state.camera_from_rig[second] * state.camera_from_rig[first].inverse();
  std::vector<OtherDistance> found;
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    const TargetView& view = problem.views[v];
    if (view.camera != second || state.pose_of_view[v] < 0) continue;
    const auto other = views_of_first.find({view.frame, view.target});
    if (other == views_of_first.end() || state.pose_of_view[other->second] == state.pose_of_view[v]) continue;
    const Rigid3 by_frame = camera_from_target(problem, state, static_cast<int>(v)) *
                            camera_from_target(problem, state, static_cast<int>(other->second)).inverse();
    const double product = by_frame.translation.norm() * by_rig.translation.norm();
    const double cosine = by_frame.translation.dot(by_rig.translation) / product;
    if (by_frame.rotation.angularDistance(by_rig.rotation) > kLargestTurn_rad) continue;
    if (!(cosine > std::cos(kLargestSlant_rad))) continue;
    found.push_back({view.frame, by_frame.translation.norm() / by_rig.translation.norm()});
  }
  return found;
}

}  // namespace

void refuse_boards_of_other_sizes(const CalibrationProblem& problem, const BundleState& state) {
  const int cameras = static_cast<int>(problem.cameras.size());
  for (int first = 0; first < cameras; ++first) {
    for (int second = first + 1; second < cameras; ++second) {
      const std::vector<OtherDistance> found = other_distances(problem, state, first, second);
      std::vector<double> factors;
      for (const OtherDistance& other : found) factors.push_back(other.factor);
      const double factor = median(factors);
      std::vector<std::string> names;
      for (const OtherDistance& other : found) {
        if (std::abs(other.factor / factor - 1.0) <= kLargestScatter) names.push_back(problem.frames[other.frame]);
      }
      std::ranges::sort(names);
      const std::size_t alike = names.size();
      if (alike < kFewestFrames || 2 * alike <= found.size()) continue;
      if (std::abs(factor - 1.0) < kSmallestDifference) continue;
      const bool many = alike > 5;
      if (many) names.resize(5);
      throw Error(
          ErrorKind::kBadInput,
          fmt::format("by {} frames ({}{}) the distance from {} to {} is {:.3f} times what it is by the others: "
                      "was a board of another size shown in them? Leave them out, or give each board its name "
                      "and size",
                      alike, fmt::join(names, ", "), many ? ", ..." : "", problem.cameras[first].name,
                      problem.cameras[second].name, factor));
    }
  }
}

}  // namespace raybundle
