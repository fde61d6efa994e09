// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "stray_dots.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

constexpr double kLeastOnBeams = 0.5;  // share of the dots
constexpr double kUsuallyOnBeams = 0.9;
constexpr int kFewestDots = 4;         // of a view, to tell something about its frame
constexpr std::size_t kMostNamed = 6;  // frames

// The first of them, 9 before 10.
std::string list_of(std::vector<std::string> names) {
  std::ranges::sort(names, {}, [](const std::string& name) { return std::pair(name.size(), name); });
  const bool all_named = names.size() <= kMostNamed;
  names.resize(std::min(names.size(), kMostNamed));
  return fmt::format("{}{}", fmt::join(names, ", "), all_named ? "" : ", ...");
}

}  // namespace

std::optional<std::string> judge_stray_dots(const LaserSolve& solve) {
  int all = 0, all_on_beams = 0;
  std::vector<std::string> strange;  // frames, each once
  for (std::size_t v = 0; v < solve.on_board.size(); ++v) {
    const auto dots = static_cast<int>(std::ranges::count(solve.on_board[v], true));
    const auto on_beams = static_cast<int>(std::ranges::count(solve.state.dot_fates[v], ObservationFate::kUsed));
    all += dots;
    all_on_beams += on_beams;
    const std::string& frame = solve.problem.frames[solve.problem.views[v].frame];
    const bool mostly_stray = dots >= kFewestDots && on_beams < kLeastOnBeams * dots;
    if (mostly_stray && std::ranges::find(strange, frame) == strange.end()) strange.push_back(frame);
  }
  const std::string counted = fmt::format("{} of the {} laser dots on boards lie on a beam", all_on_beams, all);
  const char* causes =
      "did the projector move against the cameras, do the images with the laser on and off belong to the same poses, "
      "is the grid the right one, and are its beams far enough apart?";
  if (all_on_beams < kLeastOnBeams * all) {
    throw Error(ErrorKind::kNotEnoughData, fmt::format("only {}; {}", counted, causes));
  }
  if (all_on_beams >= kUsuallyOnBeams * all && strange.empty()) return std::nullopt;
  if (strange.empty()) return fmt::format("only {}; {}", counted, causes);
  return fmt::format("most laser dots of {} frame{} ({}) lie on no beam, as if they were of another projector: {}; {}",
                     strange.size(), strange.size() == 1 ? "" : "s", list_of(strange), counted, causes);
}

}  // namespace raybundle
