// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "raybundle/bundle/bundle.hpp"

namespace raybundle {

/// The Gauss-Newton normal equations of the bundle at a state after the board poses and the beams have been eliminated:
/// the information about the cameras and the shapes of the boards.
struct ReducedInformation {
  std::vector<std::string> names;  ///< of the free parameters, as in Covariance
  Eigen::MatrixXd information;     ///< names × names, of the whitened residuals and priors
  double chi2 = 0.0;               ///< sum of squared whitened residuals
  int residuals = 0;               ///< scalar residuals, priors included
  int parameters = 0;              ///< free parameters, poses and beams included
};

ReducedInformation reduced_information(const CalibrationProblem& problem, const BundleState& state,
                                       const BundleOptions& options = {});

/// What the corners of one frame add to ReducedInformation::information, and to the gradient of half of chi2. Both are
/// after the elimination of the frame's board poses.
struct FrameInformation {
  int frame = 0;
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
  double chi2 = 0.0;        ///< sum of squared whitened residuals
  int residuals = 0;        ///< scalar residuals
  int pose_directions = 0;  ///< of the board poses' six each, those that the corners see
};

/// One entry for each frame in use, ascending. Dots and priors take no part.
std::vector<FrameInformation> information_by_frame(const CalibrationProblem& problem, const BundleState& state,
                                                   const BundleOptions& options = {});

/// reduced_information() where the frames' part of it is known.
///
/// @param frames  information_by_frame() of the same problem, state and options
ReducedInformation reduced_information(const CalibrationProblem& problem, const BundleState& state,
                                       const BundleOptions& options, const std::vector<FrameInformation>& frames);

/// How well a beam is known, for residuals whitened by their stated sigmas.
struct BeamCovariance {
  Eigen::Matrix4d of_beam;          ///< of the motion of perturbed(beam, .)
  Eigen::MatrixXd with_parameters;  ///< 4 × names of ReducedInformation: with the cameras' parameters
};

/// Marginal covariances of the state's beams, everything else being estimated with them.
///
/// @return  aligned with BundleState::beams; nothing where a beam has no information of its own
std::vector<std::optional<BeamCovariance>> beam_covariances(const CalibrationProblem& problem, const BundleState& state,
                                                            const BundleOptions& options = {});

}  // namespace raybundle
