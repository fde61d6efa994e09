// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "lens_bundle.hpp"

namespace raybundle {

/// Of each chosen view some `count` corners, spread over it, of those that agree with their neighbours on the board:
/// where a lens is smooth, a corner lies near the place that an affine map of its neighbours predicts. Needs no lens;
/// removes gross errors only.
///
/// @param chosen  indices into views
std::vector<PointsInView> screened(std::span<const PointsInView> views, const std::vector<std::size_t>& chosen,
                                   std::size_t count);

/// At most `count` corners of a view, spread over it: the extreme ones first.
PointsInView thinned(const PointsInView& view, std::size_t count);

/// Indices of at most `count` views that differ most from each other in place and size, the fullest first.
std::vector<std::size_t> spread_views(std::span<const PointsInView> views, std::size_t count);

}  // namespace raybundle
