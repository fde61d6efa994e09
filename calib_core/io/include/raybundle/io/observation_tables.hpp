// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "raybundle/scene/problem.hpp"

namespace raybundle {

/// Observations from the plain table `camera,frame,point_id,u,v[,sigma]`, with or without that header. Cameras and
/// frames stand in the order of their first line. The caller chooses the camera models.
///
/// @param name    of the file, for messages
/// @param target  the one board that was observed
/// @param sizes   image size [px] of each camera by name
/// @throws Error(kBadInput) `name:line: ...`
CalibrationProblem observations_from_csv_text(std::string_view text, const std::string& name, const Target& target,
                                              const std::map<std::string, ImageSize>& sizes);
CalibrationProblem read_observations_csv(const std::filesystem::path& path, const Target& target,
                                         const std::map<std::string, ImageSize>& sizes);

/// Which images of a corners.vnl belong to a camera.
struct VnlCamera {
  std::string name;
  std::vector<std::string> images;  ///< patterns with * and ? for the image path, or its file name when without slash
  ImageSize size;
};

/// Observations from mrcal's corners.vnl: lines `filename x y [level]`, the points of the board row by row in each
/// image. A level halves the resolution: sigma_px = 2^level; points with level - or < 0, or x or y - or < 0, are
/// missing. With the column called weight instead, sigma_px = 1 / weight. Images that match no camera are left out;
/// frames are matched by the digits in which the names of a camera differ.
/// Source: mrcal's documentation of compute_chessboard_corners().
///
/// @param target  its points, in their order, are the lines of an image
/// @throws Error(kBadInput) `name:line: ...`
CalibrationProblem observations_from_vnl_text(std::string_view text, const std::string& name, const Target& target,
                                              const std::vector<VnlCamera>& cameras);
CalibrationProblem read_observations_vnl(const std::filesystem::path& path, const Target& target,
                                         const std::vector<VnlCamera>& cameras);

}  // namespace raybundle
