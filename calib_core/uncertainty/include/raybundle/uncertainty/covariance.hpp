// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/bundle/information.hpp"

namespace raybundle {

/// Covariance of the calibration and what weakens it.
struct CovarianceResult {
  Covariance covariance;          ///< multiplied by the variance factor
  double variance_factor = 1.0;   ///< chi² per degree of freedom
  double condition_number = 1.0;  ///< of the information, columns scaled to unit diagonal
  std::vector<std::string>
      weak_parameters;  ///< that make up the weakest direction, strongest first; empty when well conditioned
  bool unseen = false;  ///< the data does not see the weakest direction at all; its variance is a lower bound
};

/// Inverse of the reduced information, by the eigenvalues of its column-scaled form. A direction that the data does not
/// see gets the largest variance that the arithmetic can tell from infinity.
CovarianceResult covariance(const ReducedInformation& information);

}  // namespace raybundle
