// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "raybundle/geometry/geodetic.hpp"
#include "raybundle/scene/survey.hpp"

namespace raybundle {

/// What heights in a table of landmarks are above. Tables do not say, and a wrong guess is off by up to 100 m.
struct HeightDatum {
  double geoid_m = 0.0;  ///< height of the zero of the table above the ellipsoid; 0 for ellipsoidal heights
};

/// The words for it: "ellipsoidal", or "orthometric:47.3" with the geoid's height there [m].
///
/// @throws Error(kBadInput) for other words
HeightDatum height_datum_from_word(const std::string& word);

/// Landmarks in the frame at an origin. The header says what the columns are, one of
///   name, lat, lon, height, sigma        degrees, metres; needs origin and datum
///   name, east, north, up, sigma         metres
///   name, azimuth, elevation, sigma      degrees from north clockwise and above the horizon; infinitely far
///
/// @throws Error(kBadInput) `name:line: ...` for bad rows, names that stand twice, an origin or datum that is missing
std::vector<Landmark> landmarks_from_csv_text(std::string_view text, const std::string& name,
                                              const std::optional<Geodetic>& origin,
                                              const std::optional<HeightDatum>& datum);

/// Sightings: image, u, v, name and, where there are several cameras, camera.
///
/// @throws Error(kBadInput) `name:line: ...` for bad rows, and landmarks that are not surveyed
std::vector<Sighting> sightings_from_csv_text(std::string_view text, const std::string& name,
                                              const std::vector<Landmark>& landmarks);

}  // namespace raybundle
