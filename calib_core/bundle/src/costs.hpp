// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ceres/cost_function.h>
#include <ceres/evaluation_callback.h>

#include <vector>

#include "unknowns.hpp"

namespace raybundle {

/// The linearisation of one view at the point that Ceres evaluates.
struct ViewSlot {
  ViewBlock block;
  bool projectable = false;
};

/// Evaluates all views before Ceres asks for them, each into its own slot. Ceres then runs on one thread and adds up in
/// a fixed order: the threads change the time, never the bits.
class ViewEvaluation final : public ceres::EvaluationCallback {
 public:
  ViewEvaluation(std::vector<ViewData> views, const Unknowns& unknowns, const BundleOptions& options,
                 const std::vector<ViewBlockOptions>& view_options);

  /// Jacobians come with every new point: most steps are accepted, and the model's projection is the larger part.
  void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override;

  const std::vector<ViewData>& views() const { return views_; }
  const ViewSlot& slot(std::size_t i) const { return slots_[i]; }
  const ViewBlockOptions& options(std::size_t i) const { return view_options_[i]; }

  /// Views that kept the solver from a step because a corner did not project there, with how often.
  const std::vector<int>& refusals() const { return refusals_; }

 private:
  std::vector<ViewData> views_;
  const Unknowns& unknowns_;
  std::vector<ViewBlockOptions> view_options_;
  int threads_;
  std::vector<ViewSlot> slots_;
  std::vector<int> refusals_;
};

/// One view as a residual block: copies what ViewEvaluation left in the slot. Parameter blocks: intrinsics,
/// [camera_from_rig,] rig_from_target [, shape].
class ViewCost final : public ceres::CostFunction {
 public:
  ViewCost(const ViewEvaluation& evaluation, std::size_t index, bool with_camera_from_rig);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  const ViewSlot& slot_;
  bool with_camera_from_rig_;
  bool with_shape_;
};

/// The priors on one block.
class PriorCost final : public ceres::CostFunction {
 public:
  PriorCost(ParameterBlock block, PriorMean mean);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  ParameterBlock block_;
  PriorMean mean_;
};

}  // namespace raybundle
