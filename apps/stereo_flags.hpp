// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/App.hpp>
#include <string>
#include <vector>

#include "raybundle/stereo/stereo.hpp"

namespace raybundle::apps {

/// Flags of every verb that rectifies a pair.
struct RectifyFlags {
  std::string left, right, projection;
  int width_px = 0, height_px = 0;
  std::vector<double> field_deg;
  std::vector<CLI::Option*> options = {};  ///< by which these are said
};
void declare_rectify_flags(CLI::App& verb, RectifyFlags& flags);

/// What the flags ask for. @throws Error(kBadInput)
RectifyOptions rectify_options(const RectifyFlags& flags);

/// The two cameras: by name, or the first two of the calibration.
struct CameraPair {
  RigCamera left, right;
};
CameraPair camera_pair(const Calibration& calibration, const RectifyFlags& flags);

/// One line about a rectified pair: projection, size, field of view, what is kept of it.
std::string rectification_text(const Rectification& pair);

struct StereoFlags {
  RectifyFlags rectify;
  double near_m = 0.0;
  int disparities = 0, least_disparity = 0, least_region_px = MatchOptions{}.least_region_px;
  int window_px = MatchOptions{}.window_px, paths = MatchOptions{}.paths;
  int coarse_levels = -1;  // as many as the search needs
  std::string cost{match_cost_name(MatchOptions{}.cost)};
  double uniqueness = MatchOptions{}.uniqueness, strength = MatchOptions{}.strength, peak = MatchOptions{}.peak;
  double least_matched_percent = 100.0 * StereoOptions{}.least_matched;
};
void declare_stereo_flags(CLI::App& verb, StereoFlags& flags);

struct StereoSetup {
  RigCamera left, right;
  StereoMatcher matcher;
  double nearest_m = 0.0;         ///< that is searched, at the middle of the image
  std::vector<std::string> said;  ///< what the user should know of it
};
StereoSetup stereo_setup(const std::string& calibration, const StereoFlags& flags, bool with_dots);

struct StereoSummary {
  int points = 0;
  double median_depth_m = 0.0;  ///< z
  double median_sigma_m = 0.0;
};
StereoSummary summary_of(const StereoFrame& frame);

}  // namespace raybundle::apps
