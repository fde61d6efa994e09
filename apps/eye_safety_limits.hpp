// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <string_view>
#include <vector>

#include "raybundle/scene/laser.hpp"

namespace raybundle::apps {

/// What an edition of IEC 60825-1 (once IEC 825-1) says differently of class 1 between 700 and 1050 nm.
///
/// Common to all: energy of a pulse 7e-4 t^0.75 C4 C6 J above Ti, constant below; C4 = 10^(0.002 (nm - 700)); C6 the
/// source's angle over 1.5 mrad; C7 = 1. Source: the figures of 1993 are those of the sensor's literature; of 2007 and
/// 2014 C4, C6, T2 and the limits were compared with public tables (ICNIRP's as printed in European regulations, open
/// implementations of EN 60825-1:2014), not with the standard's own text, which is not public. The 70 mm of 2007, where
/// an eye loupe is thought of, are from memory.
struct SafetyEdition {
  std::string_view name;
  double shortest_s;        ///< Ti: below, the single pulse's limit is constant...
  double shortest_limit_J;  ///< ... at this, times C4 C6
  bool exposure_by_size;    ///< pulses are counted and power is averaged over T2, 10 to 100 s by size; else over 100 s
  bool later_c5;            ///< C5 by length and size of the source, and sizes count up to 5 mrad or more by length
  double distance_m;        ///< of the aperture of 7 mm
};

/// The one list of editions. 1993 is what the sensor's literature used: 100 s for sight that is not intended.
inline constexpr std::array kSafetyEditions{
    SafetyEdition{"1993", 18e-6, 2e-7, false, false, 0.1},
    SafetyEdition{"2007", 18e-6, 2e-7, true, false, 0.07},
    SafetyEdition{"2014", 5e-6, 7.7e-8, true, true, 0.1},
};

/// How a laser is driven.
struct LaserDrive {
  double wavelength_nm = 850.0;  ///< 700 to 1050
  double pulse_s = 1e-3;
  double rate_Hz = 100.0;    ///< pulses; pulse_s * rate_Hz at most 1
  double source_mrad = 1.5;  ///< apparent size; 1.5 and less is a point
};

/// The greatest power during a pulse [W] that may enter an aperture of 7 mm, by each of the three rules.
struct SafetyLimit {
  double single_pulse_W = 0.0;
  double average_W = 0.0;      ///< of the mean power over the longest exposure
  double pulse_train_W = 0.0;  ///< the single pulse's limit times C5
  double c4 = 0.0, c5 = 0.0, c6 = 0.0;
  double pulses = 0.0;      ///< that were counted...
  double exposure_s = 0.0;  ///< ... in this time

  double least_W() const;
};

/// @throws Error(kBadInput) for numbers out of the range of these formulas
SafetyLimit safety_limit(const LaserDrive& drive, const SafetyEdition& edition);

/// The most beams that enter an aperture of 7 mm at a distance from the point where they come from, anywhere.
int beams_in_aperture(const std::vector<Line3>& beams, double distance_m);

}  // namespace raybundle::apps
