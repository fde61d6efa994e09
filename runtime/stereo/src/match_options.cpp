// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/stereo/match_options.hpp"

namespace raybundle {
namespace {

template <typename Keep>
CensusMask square_mask(int side_px, Keep&& keep) {
  CensusMask mask;
  const int radius = side_px / 2;
  for (int y = -radius; y <= radius; ++y) {
    for (int x = -radius; x <= radius; ++x) {
      if ((x != 0 || y != 0) && keep(x, y)) mask.push_back({x, y});
    }
  }
  return mask;
}

}  // namespace

std::string_view match_cost_name(MatchCost cost) {
  constexpr std::array<std::string_view, kMatchCosts.size()> kNames{"census", "ssd", "zncc"};
  return kNames[static_cast<std::size_t>(cost)];
}

std::optional<MatchCost> match_cost_named(std::string_view name) {
  for (const MatchCost cost : kMatchCosts) {
    if (match_cost_name(cost) == name) return cost;
  }
  return std::nullopt;
}

int coarse_levels_for(int disparities) {
  int levels = 0;
  while (disparities >> levels > 250) ++levels;
  return levels;
}

CensusMask dense_census(int side_px) {
  return square_mask(side_px, [](int, int) { return true; });
}

CensusMask sparse_census(int side_px) {
  return square_mask(side_px, [](int x, int y) { return (x + y) % 2 != 0; });
}

CensusMask census_for(int disparities) { return disparities > 128 ? sparse_census(9) : dense_census(3); }

}  // namespace raybundle
