// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/App.hpp>
#include <optional>
#include <string>
#include <vector>

#include "dataset.hpp"
#include "detect_images.hpp"

namespace raybundle::apps {

/// What the verbs that look at images or observations can be given: a dataset.toml, or the same by flags.
struct InputFlags {
  std::string dataset;               ///< path of dataset.toml
  std::string target;                ///< word, as chessboard:9x6:25mm, or a TOML file
  std::vector<std::string> cameras;  ///< NAME=IMAGES
  std::vector<std::string> models;   ///< MODEL for all cameras, or NAME=MODEL
  std::string observations;          ///< .json, .csv or .vnl file of corners that were found before
  std::vector<std::string> sizes;    ///< NAME=WxH, for observations in .csv and .vnl
  std::optional<int> threads;        ///< override the dataset's
  bool use_cache = true;
  std::string anchor;  ///< CAMERA/FRAME:U,V=ROW,COLUMN
};

/// Declares the flags on a verb, but for those of add_model_flags().
void add_input_flags(CLI::App& verb, InputFlags& flags);

/// Declares --model and --anchor: for verbs to which no calibration says what lenses and beams there are.
void add_model_flags(CLI::App& verb, InputFlags& flags);

/// How to look at the images, the flags having been merged into the data set.
DetectOptions detect_options(const InputFlags& flags, const Dataset& dataset);

/// The data set that the flags describe.
///
/// @param need_models  a camera without a model is an error
/// @throws Error(kBadInput) naming the flag or field that is missing
Dataset dataset_of(const InputFlags& flags, bool need_models);

/// Observations from images, or from the file of --observations; then files is empty.
DetectedImages observe(const InputFlags& flags, const Dataset& dataset);

}  // namespace raybundle::apps
