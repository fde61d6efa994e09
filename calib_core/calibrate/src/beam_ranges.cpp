// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "beam_ranges.hpp"

#include <algorithm>

#include "raybundle/scene/board_surface.hpp"

namespace raybundle {

std::vector<BeamRanges> ranges_of_beams(const CalibrationProblem& problem, const BundleState& state) {
  std::vector<BeamRanges> hits(state.beams.size());
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    const TargetView& view = problem.views[v];
    if (state.pose_of_view[v] < 0 || view.dots.empty()) continue;
    const BoardSurface surface(problem.targets[view.target]);
    const Rigid3& rig_from_target = state.poses[state.pose_of_view[v]].rig_from_target;
    const Rigid3 target_from_rig = rig_from_target.inverse();
    for (std::size_t i = 0; i < view.dots.size(); ++i) {
      if (state.dot_fates[v][i] != ObservationFate::kUsed) continue;
      const int b = view.dots[i].beam;
      const Line3& beam = *state.beams[b];
      const auto crossing = surface.crossing(target_from_rig * beam, state.shapes[view.target]);
      if (crossing) hits[b].ranges_m.push_back(beam.direction.dot(rig_from_target * *crossing));
    }
  }
  for (BeamRanges& of_beam : hits) std::ranges::sort(of_beam.ranges_m);
  return hits;
}

}  // namespace raybundle
