// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/App.hpp>

namespace raybundle::apps {

/// `occupancy classify`: points of the frames of one seat, of a laser or of a pair of cameras, to decisions.
void add_occupancy_classify(CLI::App& occupancy);

}  // namespace raybundle::apps
