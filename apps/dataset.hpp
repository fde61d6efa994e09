// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/scene/problem.hpp"
#include "raybundle/targets/board.hpp"
#include "survey_input.hpp"

namespace raybundle::apps {

/// A board of a data set; the name tells several boards apart.
struct DatasetBoard {
  std::string name;
  Board board;
};

/// A camera of a data set and where its images are.
struct DatasetCamera {
  std::string name;
  std::vector<std::string>
      images;         ///< paths or patterns with * and ?, relative to the folder; videos are lists of frames
  std::string model;  ///< may be empty when only detecting
  std::vector<std::string> laser_on;  ///< as images, with the laser on; they belong to the images by their frame
};

/// One dot whose beam is known: which image, where in it, which beam.
struct DatasetAnchor {
  std::string camera;
  std::string frame;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  int row = 0;
  int column = 0;
};

/// A dot projector of a data set.
struct DatasetLaser {
  LaserGrid grid;
  std::optional<int> brightest;  ///< LaserGrid::index, as are the next
  std::vector<int> missing;
  std::optional<DatasetAnchor> anchor;
};

/// What a person writes: boards, cameras, images, options. The TOML form is shown in
/// docs/formats/dataset.md.
struct Dataset {
  std::string folder;  ///< that image patterns are relative to
  std::vector<DatasetBoard> boards;
  std::vector<DatasetCamera> cameras;
  std::optional<DatasetLaser> laser;
  std::optional<SurveyInput> survey;
  std::vector<ParameterRule> rules;
  CalibrateOptions options;
};

/// Reads dataset.toml.
///
/// @throws Error(kBadInput) `file:line: ...` for malformed TOML, unknown keys (with "did you mean") and missing fields
Dataset read_dataset(const std::string& path);
Dataset dataset_from_text(const std::string& text, const std::string& path);

/// The camera of `--camera NAME=PATTERN`.
DatasetCamera camera_from_flag(const std::string& flag, const std::string& model);

/// The rule of `--fix PATTERN[=VALUE]`, `--free PATTERN` or `--prior PATTERN=MEAN:SIGMA`.
ParameterRule rule_from_flag(ParameterRule::Kind kind, const std::string& flag);

/// The anchor of `--anchor CAMERA/FRAME:U,V=ROW,COLUMN`.
DatasetAnchor anchor_from_flag(const std::string& flag);

/// The id of a model by name. Throws Error(kBadInput) with "did you mean".
ModelId model_from_name(const std::string& name, const std::string& where);

}  // namespace raybundle::apps
