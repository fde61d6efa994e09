// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "raybundle/scene/calibration.hpp"

namespace raybundle {

/// A text file.
struct NamedText {
  std::string name;  ///< its path for messages; below the folder that is written to
  std::string text;
};

/// A lens as another program's files have it.
struct ForeignLens {
  std::string_view name;  ///< theirs, as in ForeignName
  ModelId model;          ///< ours
  /// Our parameter at each of their places, with blanks between: "xi fx fy cx cy". `f` is a focal length for both axes,
  /// `0` a coefficient that our model does not have. Parameters of ours that have no place keep the start shape.
  std::string_view places;
  double max_angle_rad = std::numbers::pi;  ///< off the axis, up to which the other program projects rays by it
};

/// A camera and how it is to be written.
struct ForeignCamera {
  RigCamera camera;
  const ForeignLens* lens = nullptr;  ///< of the format, that holds the camera as it is
};

/// Files in which another program keeps cameras and where they stand. One file in calib_core/io/src/formats/ each.
struct ForeignFormat {
  std::string_view name;  ///< kalibr
  std::string_view what;  ///< what its files are, for people
  std::string_view file;  ///< what its one file is usually called; empty: one for each camera, in a folder
  bool holds_extrinsics;  ///< whether `read` finds where the cameras stand
  std::vector<ForeignLens> lenses;
  bool (*recognises)(std::string_view text);  ///< whether a file looks like one of this format
  /// The rig frame is that of the first camera.
  std::vector<NamedText> (*write)(const ForeignFormat& format, const std::vector<ForeignCamera>& rig);
  std::vector<RigCamera> (*read)(const ForeignFormat& format, std::span<const NamedText> files);
  /// Whether the program takes a camera of that lens: some refuse values; nullptr: it takes all.
  bool (*takes)(const ForeignLens& lens, const Camera& camera) = nullptr;
};

/// The one list of them.
std::span<const ForeignFormat> foreign_formats();

/// The format of that name; nullptr when there is none.
const ForeignFormat* foreign_format_named(std::string_view name);

/// Whether a lens of a format holds a camera as it is.
bool holds(const ForeignFormat& format, const ForeignLens& lens, const Camera& camera);

/// The first lens by which a format can hold a camera; nullptr when it would have to become another camera first.
const ForeignLens* lens_for(const ForeignFormat& format, const Camera& camera);

/// Indices of the parameters of lens.model that have no place in the lens: they keep the start shape.
std::vector<int> parameters_without_place(const ForeignLens& lens);

/// The files of a rig. The first camera is where the others are measured from. Cameras without a lens get lens_for().
///
/// @throws Error(kBadInput) naming the camera that the format cannot hold, or whose file would be another's
std::vector<NamedText> texts_from_rig(const ForeignFormat& format, std::vector<ForeignCamera> rig);

/// Reads a rig back. Cameras that the files do not name, or not apart, are called cam0, cam1, ...
///
/// @throws Error(kBadInput) `name:line: ...` naming the key
std::vector<RigCamera> rig_from_texts(const ForeignFormat& format, std::span<const NamedText> files);

}  // namespace raybundle
