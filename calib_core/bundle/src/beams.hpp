// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "dot_rows.hpp"
#include "raybundle/bundle/bundle.hpp"
#include "unknowns.hpp"

namespace raybundle {

/// Beams that take part, ascending: those with a used dot or a prior.
///
/// @throws Error(kBadInput) when the number of priors is neither zero nor that of the beams
std::vector<int> active_beams(const std::vector<ViewDots>& dots, const BundleState& state,
                              const BundleOptions& options);

/// The prior of a beam at a line, as a part of the normal equations of perturbed(line, .).
struct BeamPriorTerm {
  Eigen::Matrix4d matrix;
  Eigen::Vector4d gradient;
  double chi2 = 0.0;
};
BeamPriorTerm beam_prior_term(const BeamPrior& prior, const Line3& line);

/// Moves each beam's point along the beam to the middle of its dots, where offsets and slopes are least correlated.
void centre_beams(const std::vector<ViewDots>& dots, Unknowns& unknowns);

}  // namespace raybundle
