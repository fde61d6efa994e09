// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace raybundle {

struct MetricSearch {
  int steps = 0;       ///< 0: the start value is returned
  double decay = 0.0;  ///< how much the metric is drawn to zero in a step
};

/// Turns a metric so that near cases are of one class: maximises the sum over cases of the logarithm of the share that
/// their own class has of their neighbourhood, neighbours counting exp(-squared distance), by stochastic gradients.
/// The same arguments give the same bits.
///
/// @param metric      M×D, start value
/// @param attributes  D×N
/// @param classes     N
/// Source: Goldberger, Roweis, Hinton, Salakhutdinov 2004 (neighbourhood components analysis), steps by Adam (Kingma,
/// Ba 2015)
Eigen::MatrixXd neighbourhood_metric(Eigen::MatrixXd metric, const Eigen::MatrixXd& attributes,
                                     const std::vector<std::uint8_t>& classes, const MetricSearch& search);

}  // namespace raybundle
