// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/bundle/bundle.hpp"

namespace raybundle {

/// The Gauss-Newton normal equations of the bundle at a state after the board poses have been eliminated: the
/// information about everything that a Calibration holds.
struct ReducedInformation {
  std::vector<std::string> names;  ///< of the free parameters, as in Covariance
  Eigen::MatrixXd information;     ///< names × names, of the whitened residuals and priors
  double chi2 = 0.0;               ///< sum of squared whitened residuals
  int residuals = 0;               ///< scalar residuals, priors included
  int parameters = 0;              ///< free parameters, poses included
};

ReducedInformation reduced_information(const CalibrationProblem& problem, const BundleState& state,
                                       const BundleOptions& options = {});

}  // namespace raybundle
