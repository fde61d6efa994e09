// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "raybundle/bundle/bundle.hpp"

namespace raybundle {

/// What further measurements did to the cameras' free parameters.
///
/// @param known  covariance of the parameters without them
std::vector<DraggedParameter> drag_of(const CalibrationProblem& problem, const BundleState& without,
                                      const BundleState& with, const BundleOptions& bundle, const Covariance& known);

/// Says when measurements that are as good as they claim move a parameter by more than chance.
///
/// @param what     the measurements, as "the laser's dots"
/// @param mistake  what is most often wrong with them, as "wrong labels"
std::optional<std::string> drag_warning(const std::vector<DraggedParameter>& parameters, const std::string& what,
                                        const std::string& mistake);

}  // namespace raybundle
