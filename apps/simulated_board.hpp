// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "raybundle/synthetic/rig.hpp"
#include "raybundle/targets/board.hpp"

namespace raybundle::apps {

/// A rig with any board that can be drawn.
struct BoardedRig {
  SimulatedRig rig;
  Board board;
};

/// Reads a rig description, or draws one for the word `random:SEED`.
BoardedRig rig_of(const std::string& path_or_word);

}  // namespace raybundle::apps
