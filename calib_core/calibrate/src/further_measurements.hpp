// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/bundle/bundle.hpp"
#include "raybundle/calibrate/calibrate.hpp"

namespace raybundle {

/// Fills in the covariances of a solved bundle, by corners and by frames, and warns of what the views do not tell.
///
/// @throws Error(kNotEnoughData) when nothing says where a camera is on the rig
void fill_covariance(const CalibrationProblem& problem, const BundleState& state, const BundleOptions& options,
                     CalibrationResult& result);

/// What is measured beside the boards joins the bundle of cameras and boards that are solved: landmarks of a survey,
/// then the dots of a laser. Covariances, summaries and the cameras' evidence are filled in; what cannot take part is
/// told in the result's warnings.
///
/// @param problem  the dots are labelled and sigmas scaled to what the residuals show
void add_further_measurements(const CalibrateOptions& options, const BundleOptions& bundle, CalibrationProblem& problem,
                              BundleState& state, CalibrationResult& result,
                              std::vector<std::optional<CornerEvidence>>& evidence);

}  // namespace raybundle
