// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/bundle/information.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <map>

#include "block_information.hpp"
#include "layout.hpp"
#include "normal_equations.hpp"
#include "pose_rows.hpp"
#include "raybundle/geometry/error.hpp"
#include "unknowns.hpp"
#include "view_data.hpp"
#include "workers.hpp"

namespace raybundle {
namespace {

std::vector<std::string> free_names(const Layout& layout) {
  std::vector<std::string> names;
  for (const ParameterBlock& block : layout.blocks) {
    for (int i : block.free()) names.push_back(block.parameters[i].name);
  }
  return names;
}

[[noreturn]] void throw_unprojectable(const CalibrationProblem& problem, int view) {
  throw Error(ErrorKind::kSolveFailed,
              "a corner or a dot in use is not projected by the camera model; mark_projectable() and mark_dots() find "
              "such ones",
              view_name(problem, problem.views[view]));
}

// The equations at the state when there are beams, with the directions that nothing sees pinned.
struct BeamSystem {
  NormalEquations equations;
  Linearization here;
  PinnedDirections pinned;

  BeamSystem(const CalibrationProblem& problem, const BundleState& state, const BundleOptions& options)
      : equations(problem, state, options) {
    if (!equations.linearize(Unknowns(state), here)) {
      const std::vector<int>& refusals = equations.refusals();
      throw_unprojectable(problem, static_cast<int>(std::ranges::max_element(refusals) - refusals.begin()));
    }
    pinned = pin_unseen(here.system);
  }
};

int rank(const Eigen::Matrix4d& information) { return static_cast<int>(information.fullPivHouseholderQr().rank()); }

ReducedInformation information_with_beams(BeamSystem& at, const BundleOptions& options) {
  NormalEquations& equations = at.equations;
  const BlockSystem& system = at.here.system;
  ReducedInformation result{.names = free_names(equations.layout()),
                            .information = parameter_information(system, equations.workers()),
                            .chi2 = system.chi2,
                            .residuals = static_cast<int>(equations.residuals())};
  for (const PriorResidual& prior : at.here.priors) result.residuals += static_cast<int>(prior.residual.size());
  result.parameters = system.parameters() + 6 * system.poses.blocks() - at.pinned.of_poses;
  for (std::size_t b = 0; b < at.pinned.of_beam.size(); ++b) {
    result.parameters += 4 - at.pinned.of_beam[b];
    if (options.beam_priors.empty()) continue;
    const std::optional<BeamPrior>& prior = options.beam_priors[equations.beams()[b]];
    if (prior) result.residuals += rank(prior->information);
  }
  return result;
}

}  // namespace

ReducedInformation reduced_information(const CalibrationProblem& problem, const BundleState& state,
                                       const BundleOptions& options) {
  const bool with_beams = !active_beams(used_dots(problem, state), state, options).empty();
  return reduced_information(
      problem, state, options,
      with_beams ? std::vector<FrameInformation>{} : information_by_frame(problem, state, options));
}

ReducedInformation reduced_information(const CalibrationProblem& problem, const BundleState& state,
                                       const BundleOptions& options, const std::vector<FrameInformation>& frames) {
  if (!active_beams(used_dots(problem, state), state, options).empty()) {
    BeamSystem at(problem, state, options);
    return information_with_beams(at, options);
  }
  const Layout layout(estimated_blocks(problem, state, options));
  ReducedInformation result;
  result.information.setZero(layout.columns, layout.columns);
  result.parameters = layout.columns;
  result.names = free_names(layout);
  for (const FrameInformation& frame : frames) {
    result.information += frame.information;
    result.chi2 += frame.chi2;
    result.residuals += frame.residuals;
    result.parameters += frame.pose_directions;
  }
  for (const ParameterBlock& block : layout.blocks) {
    if (block.with_prior().empty()) continue;
    const PriorResidual prior = prior_residual(block, prior_mean(problem, state, block), current_values(state, block));
    const Eigen::MatrixXd rows = prior_rows(layout, block, prior);
    result.information += rows.transpose() * rows;
    result.chi2 += prior.residual.squaredNorm();
    result.residuals += static_cast<int>(prior.residual.size());
  }
  return result;
}

std::vector<FrameInformation> information_by_frame(const CalibrationProblem& problem, const BundleState& state,
                                                   const BundleOptions& options) {
  const Layout layout(estimated_blocks(problem, state, options));
  const Unknowns unknowns(state);
  Workers workers(options.threads);
  std::map<int, std::vector<ViewData>> views_of_pose;
  for (ViewData& view : used_views(problem, state, workers)) views_of_pose[view.pose].push_back(std::move(view));
  std::vector<const std::vector<ViewData>*> poses;
  for (const auto& [pose, views] : views_of_pose) poses.push_back(&views);

  std::vector<PoseEquations> equations(poses.size());
  std::vector<int> unprojectable(poses.size(), -1);
  workers.for_each(static_cast<int>(poses.size()), [&](int p) {
    unprojectable[p] = eliminate_pose(*poses[p], unknowns, layout, options.robust_scale_sigma, equations[p]);
  });
  std::map<int, FrameInformation> frames;
  for (std::size_t p = 0; p < poses.size(); ++p) {
    if (unprojectable[p] >= 0) throw_unprojectable(problem, unprojectable[p]);
    const int index = state.poses[poses[p]->front().pose].frame;
    FrameInformation& frame = frames[index];
    const Eigen::MatrixXd& left = equations[p].left;
    if (frame.gradient.size() == 0) {
      frame.frame = index;
      frame.information.setZero(layout.columns, layout.columns);
      frame.gradient.setZero(layout.columns);
    }
    frame.information += left.topLeftCorner(layout.columns, layout.columns).selfadjointView<Eigen::Upper>();
    frame.gradient += left.col(layout.columns).head(layout.columns);
    frame.chi2 += equations[p].chi2;
    frame.residuals += equations[p].residuals;
    frame.pose_directions += equations[p].directions;
  }
  std::vector<FrameInformation> result;
  for (auto& [index, frame] : frames) result.push_back(std::move(frame));
  return result;
}

std::vector<std::optional<BeamCovariance>> beam_covariances(const CalibrationProblem& problem, const BundleState& state,
                                                            const BundleOptions& options) {
  std::vector<std::optional<BeamCovariance>> result(state.beams.size());
  if (active_beams(used_dots(problem, state), state, options).empty()) return result;
  BeamSystem at(problem, state, options);
  const std::vector<BeamCovariance> covariances = marginal_beams(at.here.system, at.equations.workers());
  for (std::size_t b = 0; b < covariances.size(); ++b) {
    if (at.pinned.of_beam[b] == 0) result[at.equations.beams()[b]] = covariances[b];
  }
  return result;
}

}  // namespace raybundle
