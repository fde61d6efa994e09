// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "dataset.hpp"

namespace raybundle::apps {

/// Refuses boards that an image does not tell apart: the same print would be found as both of them, and each of its
/// corners would count twice. Two chessboards are alike whatever their sizes, as part of one looks like part of the
/// other, and so are two grids of circles; boards with markers are alike when they share some.
///
/// @throws Error(kBadInput) naming the two boards
void refuse_alike_boards(const std::vector<DatasetBoard>& boards);

}  // namespace raybundle::apps
