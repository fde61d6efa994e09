// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/bundle/bundle.hpp"

namespace raybundle {

/// Refuses frames in which a board of another size than the one described was shown. One camera cannot tell, since the
/// board may as well be nearer; but by such frames two cameras are turned to each other as by all others, and farther
/// apart or closer together by one factor.
///
/// @param state  frames that do not fit the rig have a pose for each view
/// @throws Error(kBadInput) with the frames and the factor
void refuse_boards_of_other_sizes(const CalibrationProblem& problem, const BundleState& state);

}  // namespace raybundle
