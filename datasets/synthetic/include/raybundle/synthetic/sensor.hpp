// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "raybundle/synthetic/lens_blur.hpp"
#include "raybundle/synthetic/render.hpp"

namespace raybundle {

/// Light [W/m² on a white surface] to grey values, not rounded, without noise; may be above the range.
double grey_from_light(const SimulatedSensor& sensor, double light_W_m2);

/// Reads the sensor out.
///
/// @param light  [W/m² on a white surface], vignetted
/// @param key    noise of different keys is independent, and each pixel's depends on the key and its place only
GreyImage read_out(const SimulatedSensor& sensor, const LightImage& light, bool noise, std::uint64_t key);

/// Multiplies each pixel with a random number of mean 1.
///
/// @param contrast  its standard deviation
void add_speckle(LightImage& light, double contrast, std::uint64_t key);

/// A key that depends on all bits of the words.
std::uint64_t random_key(std::uint64_t seed, std::uint64_t stream, std::uint64_t purpose);

}  // namespace raybundle
