// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/scene/target.hpp"

namespace raybundle {

/// Typical distance of a point to the nearest other one, the median [m]; infinite for a target of less than two points.
double spacing_m(const Target& target);

}  // namespace raybundle
