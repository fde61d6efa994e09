// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>
#include <filesystem>

namespace raybundle::testing {

/// A folder or file of the real data, which lies beside the sources, or where RAYBUNDLE_DATA says.
inline std::filesystem::path real_data(const std::filesystem::path& place = {}) {
  const char* named = std::getenv("RAYBUNDLE_DATA");
  const std::filesystem::path all =
      named != nullptr ? std::filesystem::path(named) : std::filesystem::path(RAYBUNDLE_SOURCE_DIR) / "../shared/data";
  return place.empty() ? all : all / place;
}

}  // namespace raybundle::testing
