// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "image_files.hpp"
#include "stereo_anchors.hpp"
#include "stereo_cabin.hpp"
#include "stereo_exposure.hpp"
#include "stereo_flags.hpp"

namespace raybundle::apps {

struct StereoReconstructionFlags {
  std::string calibration, left, right, output, vehicle, laser;
  std::vector<double> exposure;  ///< shutter [ms], gain
  StereoFlags stereo;
  SensorFlags dots;  ///< of the laser
  bool json = false;
};

/// The files of one moment.
struct StereoMoment {
  std::string name, left, right;
  std::string lit;  ///< the left camera with the laser on; empty: none
};

/// The images of one moment, of 8 bits; `lit` may be empty, or the left one itself.
struct StereoImages {
  cv::Mat left, right, lit;
};

/// Takes pairs one after the other and writes what they say.
class StereoReconstruction {
 public:
  /// @param flags  that outlive this
  explicit StereoReconstruction(const StereoReconstructionFlags& flags);

  /// Reads the images of a moment; those that are not what they should be cost only themselves, unless there is only
  /// one moment.
  void take(const StereoMoment& moment, bool only_one);

  /// @throws Error(kBadInput) when an image has another size than its camera
  void take(const StereoMoment& moment, const StereoImages& images);

  /// Writes the page and judges the sequence.
  ///
  /// @throws Error(kNotEnoughData) without any pair; GateFailed
  void finish() const;

 private:
  void require_sizes(const StereoMoment& moment, const StereoImages& images) const;
  void reconstruct(const StereoMoment& moment, const StereoImages& images);
  void judge(const StereoMoment& moment, const StereoFrame& frame, const StereoImages& images);
  void print_row(const std::string& name, const StereoFrame& frame) const;
  double matched_share(int matched) const;
  std::filesystem::path page_file() const;

  const StereoReconstructionFlags& flags_;
  StereoSetup setup_;
  std::optional<CabinWatch> cabin_;
  std::optional<LaserAnchors> anchors_;
  std::optional<ExposureAdvice> exposure_;
  nlohmann::json page_ = nlohmann::json::array();
  EightBits bits_;
  std::set<std::string> names_;  // of the frames taken
  int missed_ = 0;               // of the gate
  int exchanged_ = 0;
  int left_out_ = 0;
  int without_dots_ = 0;  // though there was an image with the laser on
};

}  // namespace raybundle::apps
