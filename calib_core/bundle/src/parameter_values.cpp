// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/bundle/parameters.hpp"
#include "raybundle/geometry/rotation.hpp"

namespace raybundle {
namespace {

using RuleKind = ParameterRule::Kind;

// d vector(exp(motion) exp(w)) / d motion at zero: the inverse of the left Jacobian of SO(3).
// Source: Solà, Deray, Atchuthan, "A micro Lie theory for state estimation in robotics", 2018, eq. 146.
Eigen::Matrix3d inverse_left_jacobian(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  const Eigen::Matrix3d cross = skew(w);
  const double factor =
      angle < 1e-4 ? 1.0 / 12.0 + angle * angle / 720.0 : 1.0 / (angle * angle) - 0.5 / (angle * std::tan(0.5 * angle));
  return Eigen::Matrix3d::Identity() - 0.5 * cross + factor * cross * cross;
}

Rigid3 mean_pose(const ParameterBlock& block, const Rigid3& start) {
  Rigid3 mean = start;
  Eigen::Vector3d turn = vector_from_rotation(start.rotation.toRotationMatrix());
  bool turned = false;
  for (int i = 0; i < 6; ++i) {
    const std::optional<double>& value = block.parameters[i].value;
    if (!value) continue;
    (i < 3 ? turn[i] : mean.translation[i - 3]) = *value;
    turned = turned || i < 3;
  }
  if (turned) mean.rotation = Eigen::Quaterniond(rotation_from_vector(turn));
  return mean;
}

void fix_pose(const ParameterBlock& block, const Rigid3& mean, Rigid3& pose) {
  int fixed_rotations = 0;
  for (int i = 0; i < 6; ++i) {
    if (block.parameters[i].kind != RuleKind::kFixed) continue;
    if (i < 3) ++fixed_rotations;
    if (i >= 3) pose.translation[i - 3] = mean.translation[i - 3];
  }
  if (fixed_rotations == 3) {
    pose.rotation = mean.rotation;
    return;
  }
  // Some components only: a given value goes into the rotation vector, the others stay as they are.
  Eigen::Vector3d turn = vector_from_rotation(pose.rotation.toRotationMatrix());
  bool turned = false;
  for (int i = 0; i < 3; ++i) {
    const Parameter& parameter = block.parameters[i];
    if (parameter.kind != RuleKind::kFixed || !parameter.value) continue;
    turn[i] = *parameter.value;
    turned = true;
  }
  if (turned) pose.rotation = Eigen::Quaterniond(rotation_from_vector(turn));
}

void fix_values(const ParameterBlock& block, const Eigen::VectorXd& mean, Eigen::Ref<Eigen::VectorXd> values) {
  for (int i = 0; i < static_cast<int>(block.parameters.size()); ++i) {
    if (block.parameters[i].kind == RuleKind::kFixed) values[i] = mean[i];
  }
}

}  // namespace

PriorMean current_values(const BundleState& state, const ParameterBlock& block) {
  switch (block.kind) {
    case ParameterBlock::Kind::kIntrinsics:
      return {.values = state.cameras[block.owner].parameters, .camera_from_rig = {}};
    case ParameterBlock::Kind::kCameraFromRig:
      return {.values = {}, .camera_from_rig = state.camera_from_rig[block.owner]};
    case ParameterBlock::Kind::kShape:
      break;
  }
  return {.values = state.shapes[block.owner].sags(), .camera_from_rig = {}};
}

PriorMean prior_mean(const CalibrationProblem& problem, const BundleState& state, const ParameterBlock& block) {
  PriorMean mean = current_values(state, block);
  if (block.kind == ParameterBlock::Kind::kCameraFromRig) {
    const ProblemCamera& camera = problem.cameras[block.owner];
    mean.camera_from_rig = mean_pose(block, camera.camera_from_rig.value_or(mean.camera_from_rig));
    return mean;
  }
  if (block.kind == ParameterBlock::Kind::kIntrinsics && problem.cameras[block.owner].parameters) {
    mean.values = *problem.cameras[block.owner].parameters;
  }
  if (block.kind == ParameterBlock::Kind::kShape) mean.values.setZero();
  for (int i = 0; i < static_cast<int>(block.parameters.size()); ++i) {
    if (block.parameters[i].value) mean.values[i] = *block.parameters[i].value;
  }
  return mean;
}

void apply_fixed_values(const CalibrationProblem& problem, const std::vector<ParameterBlock>& blocks,
                        BundleState& state) {
  for (const ParameterBlock& block : blocks) {
    if (block.kind == ParameterBlock::Kind::kIntrinsics) {
      fix_values(block, prior_mean(problem, state, block).values, state.cameras[block.owner].parameters);
    } else if (block.kind == ParameterBlock::Kind::kShape) {
      BoardShape& shape = state.shapes[block.owner];
      Eigen::Vector3d values = shape.sags();
      for (int i = 0; i < 3; ++i) {  // a shape that is only not asked for keeps its value
        if (block.parameters[i].kind == RuleKind::kFixed && block.parameters[i].value)
          values[i] = *block.parameters[i].value;
      }
      shape = BoardShape::from_sags(values);
    } else if (block.owner != 0) {
      fix_pose(block, prior_mean(problem, state, block).camera_from_rig, state.camera_from_rig[block.owner]);
    }
  }
}

PriorResidual prior_residual(const ParameterBlock& block, const PriorMean& mean, const PriorMean& current) {
  const std::vector<int> indices = block.with_prior();
  const auto size = static_cast<Eigen::Index>(block.parameters.size());
  Eigen::VectorXd difference;
  Eigen::MatrixXd slope = Eigen::MatrixXd::Identity(size, size);
  if (block.kind == ParameterBlock::Kind::kCameraFromRig) {
    difference = motion_between(mean.camera_from_rig, current.camera_from_rig);
    slope.topLeftCorner<3, 3>() = inverse_left_jacobian(difference.head<3>());
  } else {
    difference = current.values - mean.values;
  }
  PriorResidual prior;
  prior.residual.resize(static_cast<Eigen::Index>(indices.size()));
  prior.jacobian.resize(prior.residual.size(), size);
  for (Eigen::Index row = 0; row < prior.residual.size(); ++row) {
    const int i = indices[row];
    const double inverse_sigma = 1.0 / block.parameters[i].sigma;
    prior.residual[row] = difference[i] * inverse_sigma;
    prior.jacobian.row(row) = slope.row(i) * inverse_sigma;
  }
  return prior;
}

}  // namespace raybundle
