// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>

#include "raybundle/io/foreign_format.hpp"

namespace raybundle {

/// The lens of a model of ours that has a parameter at each of the places.
ForeignLens foreign_lens(std::string_view name, std::string_view model, std::string_view places,
                         double max_angle_rad = std::numbers::pi);

/// Of lenses that are programmed with x / z: nothing behind the camera.
inline constexpr double kBeforeTheCamera = std::numbers::pi / 2.0;

/// What stands at each of a lens's places, as "fx": the keys of formats that name their values.
std::vector<std::string_view> places_of(const ForeignLens& lens);

/// Their parameters of a camera that lens_for() the format holds.
std::vector<double> values_of(const ForeignLens& lens, const Camera& camera);

/// The camera that their parameters describe.
///
/// @return the camera, or what is wrong with the values, as the end of a sentence
std::pair<Camera, std::string> camera_from_values(const ForeignLens& lens, ImageSize size,
                                                  const std::vector<double>& values);

/// The lens of that name with so many values, else the first of that name; nullptr when the format has none.
const ForeignLens* lens_named(const ForeignFormat& format, std::string_view name, std::size_t values);

/// The end of a sentence about a lens that a format of ours does not have: which ones it has.
std::string known_lenses(const ForeignFormat& format);

/// A number with a point, as `800.0` and `1.0e-05`: for readers that take a number without one for something else.
std::string real_text(double value);

/// [1.0, 2.0]
std::string list_text(const std::vector<double>& values);

/// A matrix as cv::FileStorage writes it, row by row.
std::string opencv_matrix_text(const std::string& key, int rows, int columns, const std::vector<double>& data);

/// A text in double quotes, as JSON and YAML read it.
std::string quoted(const std::string& text);

/// The name of a camera as that of a file: slashes, blanks and control characters become underscores.
std::string file_stem(const std::string& camera);

/// left.yaml, in whatever folder: left.
std::string stem_of(const std::string& path);

/// What cameras are called in files that do not name them.
std::string numbered_camera(std::size_t index);

}  // namespace raybundle
