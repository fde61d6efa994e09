// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "dataset.hpp"
#include "image_files.hpp"
#include "raybundle/io/observations_file.hpp"
#include "raybundle/io/report_file.hpp"

namespace raybundle::apps {

/// What detection found in the images of a data set.
struct DetectedImages {
  ObservationsFile observations;  ///< rules and start values are still to be added to its problem
  std::vector<ImageFile> files;
  std::vector<ImageFile> laser_files;  ///< with the laser on
  std::vector<UnusedImage> unused;
  std::vector<std::string> hints;         ///< what may be set wrongly, without repetition
  std::map<std::string, int> seen_sizes;  ///< of chessboards that do not fit the one asked for, in how many images
  double seconds = 0.0;
};

struct DetectOptions {
  int threads = 2;
  bool use_cache = true;
};

/// A reason or hint by its words: those that differ in a figure only say the same.
std::string without_digits(std::string text);

/// Finds the boards of a data set in all of its images, on several threads, with progress; results are cached by the
/// content of the image and the board.
///
/// @throws Error(kBadInput) when a camera has images of different sizes and none that most of them have, for an image
///   of two cameras, and for boards that images do not tell apart
DetectedImages detect_images(const Dataset& dataset, const DetectOptions& options);

/// Refuses images without any board, and images of which as many show another size of board as the one asked for, or
/// half as many where most show neither: what was found in the others is then a misreading.
///
/// @throws Error(kNotEnoughData) with what the images show instead
void require_views(const DetectedImages& images);

}  // namespace raybundle::apps
