// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <ceres/ceres.h>

#include <algorithm>
#include <memory>

#include "costs.hpp"
#include "pose_manifold.hpp"
#include "raybundle/bundle/bundle.hpp"

namespace raybundle {
namespace {

bool shape_is_estimated(const std::vector<ParameterBlock>& blocks, int target) {
  return std::ranges::any_of(blocks, [&](const ParameterBlock& block) {
    return block.kind == ParameterBlock::Kind::kShape && block.owner == target && !block.fixed();
  });
}

std::vector<ViewBlockOptions> options_of_views(const std::vector<ViewData>& views,
                                               const std::vector<ParameterBlock>& blocks,
                                               const BundleOptions& options) {
  std::vector<ViewBlockOptions> result;
  for (const ViewData& view : views) {
    result.push_back({.with_shape = shape_is_estimated(blocks, view.target),
                      .compressed = options.compressed_views,
                      .robust_scale_sigma = options.robust_scale_sigma});
  }
  return result;
}

// Some components of a vector held: SubsetManifold wants those that are held.
ceres::Manifold* vector_manifold(const ParameterBlock& block) {
  std::vector<int> held;
  const std::vector<int> free = block.free();
  for (int i = 0; i < static_cast<int>(block.parameters.size()); ++i) {
    if (!std::ranges::binary_search(free, i)) held.push_back(i);
  }
  return held.empty() ? nullptr : new ceres::SubsetManifold(static_cast<int>(block.parameters.size()), held);
}

// Everything that Ceres refers to, in the order in which it has to outlive the ceres::Problem.
class CeresBundle {
 public:
  CeresBundle(const CalibrationProblem& problem, const BundleState& state, const BundleOptions& options)
      : blocks_(estimated_blocks(problem, state, options)),
        unknowns_(state),
        evaluation_(used_views(problem, state), unknowns_, options,
                    options_of_views(used_views(problem, state), blocks_, options)),
        pose_manifold_({0, 1, 2, 3, 4, 5}) {
    ceres::Problem::Options problem_options;
    problem_options.evaluation_callback = &evaluation_;
    problem_options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    problem_ = std::make_unique<ceres::Problem>(problem_options);
    for (std::size_t i = 0; i < evaluation_.views().size(); ++i) add_view(i);
    for (const ParameterBlock& block : blocks_) add_block(problem, state, block);
  }

  ceres::Solver::Summary solve(const BundleOptions& options) {
    ceres::Solver::Options solver;
    solver.linear_solver_type = ceres::DENSE_SCHUR;
    solver.linear_solver_ordering = ordering_;
    solver.max_num_iterations = options.max_iterations;
    solver.num_threads = 1;
    solver.logging_type = ceres::SILENT;
    // Tight: what is left after the last step is far below every sigma, so that answers do not depend on the order of
    // the views, and exact data give the exact answer.
    solver.function_tolerance = 1e-14;
    solver.parameter_tolerance = 1e-12;
    solver.gradient_tolerance = 1e-14;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, problem_.get(), &summary);
    return summary;
  }

  const Unknowns& unknowns() const { return unknowns_; }
  const ViewEvaluation& evaluation() const { return evaluation_; }

 private:
  void add_view(std::size_t index) {
    const ViewData& view = evaluation_.views()[index];
    const bool with_camera_from_rig = view.camera != 0;  // the first camera's is the identity
    std::vector<double*> parameters{unknowns_.intrinsics(view.camera)};
    if (with_camera_from_rig) parameters.push_back(unknowns_.camera_from_rig(view.camera));
    double* pose = unknowns_.rig_from_target(view.pose);
    parameters.push_back(pose);
    if (evaluation_.options(index).with_shape) parameters.push_back(unknowns_.shape(view.target));
    problem_->AddResidualBlock(new ViewCost(evaluation_, index, with_camera_from_rig), nullptr, parameters);
    problem_->SetManifold(pose, &pose_manifold_);
    ordering_->AddElementToGroup(pose, 0);
  }

  void add_block(const CalibrationProblem& problem, const BundleState& state, const ParameterBlock& block) {
    double* values = unknowns_.values(block);
    if (!problem_->HasParameterBlock(values)) return;  // no view depends on it
    ordering_->AddElementToGroup(values, 1);
    if (block.fixed()) {
      problem_->SetParameterBlockConstant(values);
      return;
    }
    const bool pose = block.kind == ParameterBlock::Kind::kCameraFromRig;
    if (ceres::Manifold* manifold = pose ? new PoseManifold(block.free()) : vector_manifold(block)) {
      problem_->SetManifold(values, manifolds_.emplace_back(manifold).get());
    }
    if (!block.with_prior().empty()) {
      problem_->AddResidualBlock(new PriorCost(block, prior_mean(problem, state, block)), nullptr, values);
    }
  }

  std::vector<ParameterBlock> blocks_;
  Unknowns unknowns_;
  ViewEvaluation evaluation_;
  PoseManifold pose_manifold_;
  std::vector<std::unique_ptr<ceres::Manifold>> manifolds_;
  std::shared_ptr<ceres::ParameterBlockOrdering> ordering_ = std::make_shared<ceres::ParameterBlockOrdering>();
  std::unique_ptr<ceres::Problem> problem_;
};

Termination termination_of(const ceres::Solver::Summary& summary) {
  if (!summary.IsSolutionUsable()) return Termination::kFailed;
  return summary.termination_type == ceres::CONVERGENCE ? Termination::kConverged : Termination::kIterationLimit;
}

std::string message_of(const CalibrationProblem& problem, const ceres::Solver::Summary& summary,
                       const ViewEvaluation& evaluation) {
  std::string message = summary.message;
  const auto most = std::ranges::max_element(evaluation.refusals());
  if (most == evaluation.refusals().end() || *most == 0) return message;
  const ViewData& view = evaluation.views()[most - evaluation.refusals().begin()];
  return message + "; " + std::to_string(*most) + " steps were refused because they would have moved corners of " +
         view_name(problem, problem.views[view.view]) + " to where its camera model does not project";
}

}  // namespace

BundleSummary solve_bundle(const CalibrationProblem& problem, BundleState& state, const BundleOptions& options) {
  apply_fixed_values(problem, parameter_blocks(problem), state);
  CeresBundle bundle(problem, state, options);
  if (bundle.evaluation().views().empty()) {
    return {.termination = Termination::kFailed, .message = "no observation is in use"};
  }
  const ceres::Solver::Summary summary = bundle.solve(options);
  BundleSummary result{.termination = termination_of(summary),
                       .iterations = summary.num_successful_steps + summary.num_unsuccessful_steps,
                       .initial_cost = summary.initial_cost,
                       .final_cost = summary.final_cost,
                       .message = message_of(problem, summary, bundle.evaluation())};
  if (result.termination != Termination::kFailed) bundle.unknowns().store(state);
  return result;
}

}  // namespace raybundle
