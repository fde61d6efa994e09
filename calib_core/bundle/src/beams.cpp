// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "beams.hpp"

#include <string>

#include "raybundle/geometry/error.hpp"

namespace raybundle {

std::vector<int> active_beams(const std::vector<ViewDots>& dots, const BundleState& state,
                              const BundleOptions& options) {
  if (!options.beam_priors.empty() && options.beam_priors.size() != state.beams.size()) {
    throw Error(ErrorKind::kBadInput, "there are " + std::to_string(options.beam_priors.size()) + " priors for " +
                                          std::to_string(state.beams.size()) + " beams; give one for each, or none");
  }
  std::vector<bool> active(state.beams.size(), false);
  for (const ViewDots& view : dots) {
    for (const UsedDot& dot : view.dots) active[dot.beam] = true;
  }
  std::vector<int> beams;
  for (int b = 0; b < static_cast<int>(active.size()); ++b) {
    const bool has_prior = !options.beam_priors.empty() && options.beam_priors[b].has_value();
    if (state.beams[b] && (active[b] || has_prior)) beams.push_back(b);
  }
  return beams;
}

BeamPriorTerm beam_prior_term(const BeamPrior& prior, const Line3& line) {
  const Eigen::Vector4d motion = motion_between(prior.line, line);
  const Eigen::Vector3d& normal = prior.line.direction;
  const double along = normal.dot(line.direction);
  const double distance = normal.dot(prior.line.point - line.point) / along;
  // A motion of the line moves its crossing with the prior's plane within that plane, obliquely along the line.
  const Eigen::Matrix<double, 3, 2> basis = across(line.direction);
  const Eigen::Matrix<double, 3, 2> in_plane = basis - line.direction * (normal.transpose() * basis) / along;
  const Eigen::Matrix2d slope = across(normal).transpose() * in_plane;
  Eigen::Matrix4d jacobian;
  jacobian << slope, distance * slope, Eigen::Matrix2d::Zero(), slope / along;
  BeamPriorTerm term;
  term.matrix = jacobian.transpose() * prior.information * jacobian;
  term.gradient = jacobian.transpose() * (prior.information * motion);
  term.chi2 = motion.dot(prior.information * motion);
  return term;
}

void centre_beams(const std::vector<ViewDots>& dots, Unknowns& unknowns) {
  std::vector<double> sum(unknowns.beams.size(), 0.0);
  std::vector<int> count(unknowns.beams.size(), 0);
  for (const ViewDots& view : dots) {
    const Rigid3& rig_from_target = unknowns.rig_from_target[view.pose];
    const Rigid3 target_from_rig = rig_from_target.inverse();
    const Eigen::Vector3d& sags = unknowns.shapes[view.target];
    for (const UsedDot& dot : view.dots) {
      const Line3& beam = unknowns.beams[dot.beam];
      const Line3 in_target = target_from_rig * beam;
      const auto x = view.surface.crossing(in_target, BoardShape::from_sags(sags));
      if (!x) continue;
      sum[dot.beam] += in_target.direction.dot(*x - in_target.point);
      ++count[dot.beam];
    }
  }
  for (std::size_t b = 0; b < sum.size(); ++b) {
    if (count[b] > 0) unknowns.beams[b].point = unknowns.beams[b].at(sum[b] / count[b]);
  }
}

}  // namespace raybundle
