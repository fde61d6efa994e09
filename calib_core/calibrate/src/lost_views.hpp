// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "raybundle/bundle/bundle.hpp"
#include "raybundle/calibrate/calibrate.hpp"

namespace raybundle {

/// Looks once more for the poses of views that were lost, and keeps what fits all corners better.
///
/// A board that looks like itself when it is turned may have got a wrong pose that many corners do not fit: it is posed
/// anew. Where the others show nothing a lens of many coefficients may go anywhere, and a right view there does not fit
/// it: views that were set aside are posed under a lens of one coefficient, which goes on beyond the corners that it
/// was fitted to, and all coefficients are solved for from there.
///
/// @param single   the problem of one camera
/// @param reasons  aligned with its views; why one has no pose
/// @param summary  of the state's solve
void win_back_views(const CalibrationProblem& single, BundleState& state, const CalibrateOptions& options,
                    std::vector<std::string>& reasons, BundleSummary& summary);

}  // namespace raybundle
