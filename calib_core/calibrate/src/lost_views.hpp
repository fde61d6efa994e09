// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "robust_solve.hpp"

namespace raybundle {

/// Looks once more for the poses of views that were lost, and keeps what fits all corners better.
///
/// A board that looks like itself when it is turned may have got a wrong pose that many corners do not fit: it is posed
/// anew. Where the others show nothing a lens may go anywhere, and a right view there does not fit it: views that were
/// set aside are posed where they fit it poorly, and under a lens whose higher coefficients are zero, which goes on
/// beyond the corners that it was fitted to; all coefficients are solved for from there.
///
/// @param single  the problem of one camera
/// @return        whether the state changed
bool win_back_views(const CalibrationProblem& single, const CalibrateOptions& options, SolvedState& solved);

}  // namespace raybundle
