// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mrcal_solve.hpp"
#include "raybundle/scene/problem.hpp"
#include "raybundle/scene/result.hpp"

namespace raybundle {

/// Why mrcal cannot be asked about a rig at all, one sentence; empty when it can.
std::string mrcal_objection(const CalibrationProblem& problem, const CalibrationResult& first);

/// The corners that a solve used, with the labels that it settled on, and its poses; cameras have no parameters and the
/// lens model no name yet. There must be no objection.
MrcalProblem mrcal_request(const CalibrationProblem& problem, const CalibrationResult& first);

/// Whether a board is not held to be flat.
bool is_bent(const BoardShape& shape);

}  // namespace raybundle
