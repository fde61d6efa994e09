// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "costs.hpp"

#include "parallel.hpp"

namespace raybundle {
namespace {

using RowMajor = ViewBlock::Rows;

// Into a Ceres Jacobian that may have more columns than ours (PoseManifold).
void copy(const RowMajor& from, double* to, Eigen::Index columns) {
  if (columns == from.cols()) {
    std::copy_n(from.data(), from.size(), to);
    return;
  }
  Eigen::Map<RowMajor> out(to, from.rows(), columns);
  out.leftCols(from.cols()) = from;
  out.rightCols(columns - from.cols()).setZero();
}

}  // namespace

ViewEvaluation::ViewEvaluation(std::vector<ViewData> views, const Unknowns& unknowns, const BundleOptions& options,
                               const std::vector<ViewBlockOptions>& view_options)
    : views_(std::move(views)),
      unknowns_(unknowns),
      view_options_(view_options),
      threads_(options.threads),
      slots_(views_.size()),
      refusals_(views_.size(), 0) {}

void ViewEvaluation::PrepareForEvaluation(bool, bool new_evaluation_point) {
  if (!new_evaluation_point) return;
  parallel_for(static_cast<int>(views_.size()), threads_, [&](int i) {
    slots_[i].projectable = linearize_view(views_[i], unknowns_.at(views_[i]), view_options_[i], slots_[i].block);
    if (!slots_[i].projectable) ++refusals_[i];
  });
}

ViewCost::ViewCost(const ViewEvaluation& evaluation, std::size_t index, bool with_camera_from_rig)
    : slot_(evaluation.slot(index)),
      with_camera_from_rig_(with_camera_from_rig),
      with_shape_(evaluation.options(index).with_shape) {
  const ViewData& view = evaluation.views()[index];
  set_num_residuals(view_block_rows(view, evaluation.options(index)));
  std::vector<int32_t>& sizes = *mutable_parameter_block_sizes();
  sizes.push_back(with_model(view.model, []<CameraModel M>() { return kParameterCount<M>; }));
  if (with_camera_from_rig) sizes.push_back(7);
  sizes.push_back(7);
  if (with_shape_) sizes.push_back(3);
}

bool ViewCost::Evaluate(double const* const*, double* residuals, double** jacobians) const {
  if (!slot_.projectable) return false;
  const ViewBlock& block = slot_.block;
  std::copy_n(block.residual.data(), block.residual.size(), residuals);
  if (jacobians == nullptr) return true;
  std::size_t next = 0;
  const auto put = [&](const RowMajor& rows) {
    if (jacobians[next] != nullptr) copy(rows, jacobians[next], parameter_block_sizes()[next]);
    ++next;
  };
  put(block.wrt_intrinsics);
  if (with_camera_from_rig_) put(block.wrt_camera_from_rig);
  put(block.wrt_rig_from_target);
  if (with_shape_) put(block.wrt_shape);
  return true;
}

PriorCost::PriorCost(ParameterBlock block, PriorMean mean) : block_(std::move(block)), mean_(std::move(mean)) {
  set_num_residuals(static_cast<int>(block_.with_prior().size()));
  const bool pose = block_.kind == ParameterBlock::Kind::kCameraFromRig;
  mutable_parameter_block_sizes()->push_back(pose ? 7 : static_cast<int>(block_.parameters.size()));
}

bool PriorCost::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  PriorMean current;
  if (block_.kind == ParameterBlock::Kind::kCameraFromRig) {
    current.camera_from_rig = rigid_from(parameters[0]);
  } else {
    current.values = Eigen::Map<const Eigen::VectorXd>(parameters[0], parameter_block_sizes()[0]);
  }
  const PriorResidual prior = prior_residual(block_, mean_, current);
  std::copy_n(prior.residual.data(), prior.residual.size(), residuals);
  if (jacobians != nullptr && jacobians[0] != nullptr) copy(prior.jacobian, jacobians[0], parameter_block_sizes()[0]);
  return true;
}

}  // namespace raybundle
