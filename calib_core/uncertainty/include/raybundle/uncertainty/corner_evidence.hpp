// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/bundle/bundle.hpp"
#include "raybundle/scene/calibration.hpp"

namespace raybundle {

/// Cells of CornerEvidence along the longer side of an image.
inline constexpr int kEvidenceCells = 16;

/// What a camera's used corners say beside its parameters; nothing when it has none. Kept in a saved calibration, it
/// is all that projection_uncertainty.hpp needs of the solve.
///
/// Source of the implied motion: mrcal's cross-reprojection uncertainty, linearised; deviation: one camera at a time,
/// so that the answer is that of the lens alone.
std::optional<CornerEvidence> corner_evidence(const CalibrationProblem& problem, const BundleState& state, int camera);

}  // namespace raybundle
