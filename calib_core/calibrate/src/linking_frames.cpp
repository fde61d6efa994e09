// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/calibrate/linking_frames.hpp"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

namespace raybundle {

LinkingFrames linking_frames(const CalibrationProblem& problem, const CalibrationResult& result) {
  std::map<std::pair<int, int>, std::vector<int>> poses;  // of the views of each frame and board
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    if (result.views[v].pose < 0) continue;
    poses[{problem.views[v].frame, problem.views[v].target}].push_back(result.views[v].pose);
  }
  LinkingFrames frames;
  for (auto& [board, of_board] : poses) {
    if (of_board.size() < 2) continue;
    ++frames.shared;
    std::ranges::sort(of_board);
    frames.linking += std::ranges::adjacent_find(of_board) != of_board.end();
  }
  return frames;
}

}  // namespace raybundle
