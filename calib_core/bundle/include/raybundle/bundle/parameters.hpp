// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "raybundle/bundle/bundle.hpp"

namespace raybundle {

/// One scalar that a Calibration holds, and what the problem's rules say about it.
struct Parameter {
  std::string name;  ///< right.camera_from_rig.translation_x
  ParameterRule::Kind kind = ParameterRule::Kind::kFree;
  std::optional<double> value;  ///< of the rule
  double sigma = 0.0;           ///< of the prior
};

/// Parameters that are estimated together. Board poses are not among them: no rule and no covariance names them.
struct ParameterBlock {
  enum class Kind { kIntrinsics, kCameraFromRig, kShape };
  Kind kind = Kind::kIntrinsics;
  int owner = 0;      ///< index of the camera or of the target
  std::string group;  ///< name of all of them: left.intrinsics, right.camera_from_rig, board.shape
  std::vector<Parameter> parameters;

  std::vector<int> free() const;        ///< indices of the parameters that are not fixed, ascending
  std::vector<int> with_prior() const;  ///< indices of the parameters with a prior, ascending
  bool fixed() const { return free().empty(); }
};

/// Every parameter of the problem by name, in the order of Covariance::names: camera by camera intrinsics and
/// extrinsics, then the board shapes; with problem.rules applied. The first camera's extrinsics are fixed whatever the
/// rules say: they define the rig frame.
///
/// A pattern matches a parameter when it matches its name or the name of its group; * and ? also match dots.
///
/// @throws Error(kBadInput) for a rule that matches nothing, or a prior without a positive sigma
std::vector<ParameterBlock> parameter_blocks(const CalibrationProblem& problem);

/// Whether a rule speaks of any parameter of the problem.
bool matches_any(const ParameterRule& rule, const CalibrationProblem& problem);

/// The blocks as solve_bundle and reduced_information treat them: what no used observation depends on is fixed too, and
/// so are the board shapes that are not asked for.
std::vector<ParameterBlock> estimated_blocks(const CalibrationProblem& problem, const BundleState& state,
                                             const BundleOptions& options);

/// Where the priors of a block pull to: the rule's value, else the problem's start, else the state; zero for shapes.
/// For extrinsics a rule's rotation value is a component of the rotation vector [rad].
struct PriorMean {
  Eigen::VectorXd values;  ///< of intrinsics and shapes
  Rigid3 camera_from_rig;
};
PriorMean prior_mean(const CalibrationProblem& problem, const BundleState& state, const ParameterBlock& block);

/// Writes the values of the rules that fix parameters into the state; without a value the problem's start stays or,
/// when it has none, the state.
void apply_fixed_values(const CalibrationProblem& problem, const std::vector<ParameterBlock>& blocks,
                        BundleState& state);

/// The block's current values in the form of PriorMean.
PriorMean current_values(const BundleState& state, const ParameterBlock& block);

/// (value - mean) / sigma of each prior of a block, in the order of with_prior(), with the Jacobian by all of the
/// block's parameters (extrinsics: by the motion of perturbed()).
struct PriorResidual {
  Eigen::VectorXd residual;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> jacobian;
};
PriorResidual prior_residual(const ParameterBlock& block, const PriorMean& mean, const PriorMean& current);

}  // namespace raybundle
