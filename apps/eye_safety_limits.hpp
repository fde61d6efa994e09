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
struct SafetyEdition {
  std::string_view name;
  double shortest_s;         ///< below, the single pulse's limit is constant...
  double shortest_limit_J;   ///< ... at this, times C4 C6; above it is 7e-4 t^0.75 C4 C6
  double longest_pulses_s;   ///< exposure over which pulses are counted and power is averaged; of a small source
  bool small_sources_count;  ///< pulses of a train lower the limit of a small source (C5 = N^-1/4); else C5 = 1
};

/// The one list of editions. 1993 is what the sensor's literature used: 100 s for sight that is not intended.
inline constexpr std::array kSafetyEditions{
    SafetyEdition{"1993", 18e-6, 2e-7, 100.0, true},
    SafetyEdition{"2007", 18e-6, 2e-7, 10.0, true},
    SafetyEdition{"2014", 5e-6, 7.7e-8, 10.0, false},
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
  double pulses = 0.0;  ///< that were counted

  double least_W() const;
};

/// @throws Error(kBadInput) for numbers out of the range of these formulas
SafetyLimit safety_limit(const LaserDrive& drive, const SafetyEdition& edition);

/// The most beams that enter an aperture of 7 mm at 100 mm from the point where they come from, anywhere.
int beams_in_aperture(const std::vector<Line3>& beams);

}  // namespace raybundle::apps
