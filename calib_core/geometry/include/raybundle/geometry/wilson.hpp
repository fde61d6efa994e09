// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

namespace raybundle {

/// One end of Wilson's interval (1927) about a share that was counted.
///
/// @param share   of the trials, 0 to 1
/// @param trials  0 says nothing: the end is then 0 or 1
/// @param sigmas  of a normal number, by which the end lies above the share; below it when negative
/// @return        0 to 1
inline double wilson_bound(double share, double trials, double sigmas) {
  if (trials <= 0.0) return sigmas < 0.0 ? 0.0 : 1.0;
  const double z2 = sigmas * sigmas;
  const double middle = share + z2 / (2 * trials);
  const double off = sigmas * std::sqrt(share * (1 - share) / trials + z2 / (4 * trials * trials));
  return std::clamp((middle + off) / (1 + z2 / trials), 0.0, 1.0);
}

}  // namespace raybundle
