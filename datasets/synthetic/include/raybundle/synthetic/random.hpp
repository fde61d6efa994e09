// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>

namespace raybundle {

/// Bits that look independent for words that differ in one bit. Source: Steele, Lea, Flood 2014, SplitMix64.
std::uint64_t mixed_bits(std::uint64_t word);

/// The standard normal's quantile. Source: Wichura 1988, algorithm AS 241 (PPND16), relative error 1e-16.
///
/// @param p  in (0, 1)
double normal_quantile(double p);

/// Random numbers whose bits depend on the seed only: the distributions of the standard library differ between
/// libraries, the engine does not.
class Random {
 public:
  /// @param stream  numbers of different streams of one seed are independent: a frame, a camera, ...
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0);

  double uniform();  ///< in (0, 1)
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  int below(int count);  ///< 0 .. count - 1
  bool chance(double probability) { return uniform() < probability; }

  double normal() { return normal_quantile(uniform()); }  ///< standard normal

 private:
  std::mt19937_64 engine_;
};

}  // namespace raybundle
