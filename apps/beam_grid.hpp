// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "raybundle/scene/laser.hpp"

namespace raybundle::apps {

/// The beams that a word counts, COLUMNSxROWS as in 19x16; nothing when it is no such word.
///
/// @param least  beams each way; there are at most 64
std::optional<LaserGrid> beam_grid_from_word(const std::string& word, int least);

/// The same for --beams, of which there are two or more each way.
///
/// @throws Error(kBadInput)
LaserGrid beam_grid_from_flag(const std::string& word);

}  // namespace raybundle::apps
