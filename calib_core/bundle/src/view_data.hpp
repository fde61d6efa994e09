// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/bundle/view_block.hpp"
#include "workers.hpp"

namespace raybundle {

/// used_views(), gathered by several threads.
std::vector<ViewData> used_views(const CalibrationProblem& problem, const BundleState& state, Workers& workers);

}  // namespace raybundle
