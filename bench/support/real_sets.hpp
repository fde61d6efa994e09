// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "raybundle/scene/problem.hpp"

namespace raybundle::bench {

/// A set of real images of one board by one camera, or by several at the same moments.
struct RealSet {
  std::string name;
  std::string folder;                ///< in the folder of real data
  std::string board;                 ///< as on the command line
  std::vector<std::string> cameras;  ///< NAME=PATTERN in the folder
};

std::vector<RealSet> real_sets();

/// What `raybundle detect` finds in the images; nothing when they are not there.
///
/// @param program  the raybundle of this build
std::optional<CalibrationProblem> observations_of(const RealSet& set, const std::filesystem::path& program);

}  // namespace raybundle::bench
