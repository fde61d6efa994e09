// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdio>

namespace raybundle::bench {

struct Unit {
  const char* name;
  double scale;  ///< of the figure, to print it
};
inline constexpr Unit kPercent{"%", 100.0}, kMillimetres{"mm", 1e3};

/// A line with a figure and the bar that it must not go beyond.
///
/// @return  whether it holds
inline bool print_judged(const char* what, double value, double bar, Unit unit, bool good) {
  std::printf("  %-52s %8.3f %-3s bar %8.3f  %s\n", what, unit.scale * value, unit.name, unit.scale * bar,
              good ? "ok" : "FAILS");
  std::fflush(stdout);
  return good;
}
inline bool at_least(double bar, const char* what, double value, Unit unit) {
  return print_judged(what, value, bar, unit, value >= bar);
}
inline bool at_most(double bar, const char* what, double value, Unit unit) {
  return print_judged(what, value, bar, unit, value <= bar);
}

}  // namespace raybundle::bench
