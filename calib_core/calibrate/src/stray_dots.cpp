// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "stray_dots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "raybundle/geometry/error.hpp"
#include "raybundle/uncertainty/held_out_dots.hpp"

namespace raybundle {
namespace {

constexpr double kLeastOnBeams = 0.5;  // share of the dots
constexpr double kUsuallyOnBeams = 0.9;
constexpr int kFewestDots = 4;         // of a view, to tell something about its frame
constexpr std::size_t kMostNamed = 6;  // frames

// Dots of each view that lie amid the points of its board.
std::vector<int> dots_amid_boards(const LaserSolve& solve) {
  const CalibrationProblem& problem = solve.problem;
  const BundleState& state = solve.state;
  Calibration solved;
  for (std::size_t c = 0; c < problem.cameras.size(); ++c) {
    solved.cameras.push_back({problem.cameras[c].name, state.cameras[c], state.camera_from_rig[c]});
  }
  for (std::size_t t = 0; t < problem.targets.size(); ++t) {
    solved.targets.push_back({problem.targets[t], state.shapes[t]});
  }
  solved.laser = solve.pattern;
  std::vector<std::optional<Rigid3>> rig_from_target;
  for (const int pose : state.pose_of_view) {
    rig_from_target.push_back(pose < 0 ? std::nullopt : std::optional(state.poses[pose].rig_from_target));
  }
  std::vector<int> on_boards;
  for (const DotsOnBoard& of_view : dots_on_boards(solved, problem, rig_from_target)) {
    on_boards.push_back(of_view.dots);
  }
  return on_boards;
}

// The first of them, 9 before 10.
std::string list_of(std::vector<std::string> names) {
  std::ranges::sort(names, {}, [](const std::string& name) { return std::pair(name.size(), name); });
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMostNamed); ++i) text += (i > 0 ? ", " : "") + names[i];
  return names.size() > kMostNamed ? text + ", ..." : text;
}

}  // namespace

std::optional<std::string> judge_stray_dots(const LaserSolve& solve) {
  const std::vector<int> on_boards = dots_amid_boards(solve);
  int all = 0, all_on_beams = 0;
  std::vector<std::string> strange;  // frames, each once
  for (std::size_t v = 0; v < on_boards.size(); ++v) {
    const auto used = static_cast<int>(std::ranges::count(solve.state.dot_fates[v], ObservationFate::kUsed));
    const int on_beams = std::min(used, on_boards[v]);
    all += on_boards[v];
    all_on_beams += on_beams;
    const std::string& frame = solve.problem.frames[solve.problem.views[v].frame];
    const bool mostly_stray = on_boards[v] >= kFewestDots && on_beams < kLeastOnBeams * on_boards[v];
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
