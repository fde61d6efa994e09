// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "raybundle/uncertainty/projection_uncertainty.hpp"

namespace raybundle {

/// Beyond this many summed sigmas two calibrations differ by more than their noise explains ...
inline constexpr double kMostSummedSigmas = 2.0;
/// ... unless they do so in less than the rest of the image.
inline constexpr double kLeastShareWithin = 0.9;

/// Which covariance sigmas come from.
enum class SigmasFrom {
  kCorners,  ///< Calibration::covariance
  kFrames,   ///< Calibration::covariance_by_frame
};

/// How the images of one camera differ between two calibrations of it. Matrices have one entry for each of equal cells
/// of the image; NaN where not both calibrations saw corners (or the one that tells), or a model has no ray.
struct ProjectionDifference {
  std::string camera;
  ImageSize size;
  double range_m = kInfinitelyFar;
  Eigen::MatrixXd u_px;  ///< where b sees what a sees in the middle of the cell, minus that
  Eigen::MatrixXd v_px;
  Eigen::MatrixXd sigma_px;    ///< sum of both sigmas of it: of a's and b's projections, largest direction
  Rigid3 b_from_a;             ///< motion of the surroundings that was taken out; at infinity a rotation only
  double covered_share = 0.0;  ///< of the cells of the image, those with an entry
  double lost_share = 0.0;     ///< of CornerEvidence's cells that both saw, those in which only one of the lenses sees
  double rms_px = 0.0;
  double largest_px = 0.0;
  double share_within = 1.0;  ///< as share_within() of kMostSummedSigmas

  bool agrees() const { return share_within >= kLeastShareWithin; }
};

/// Of the cells with an entry, those that differ by at most so many summed sigmas; 1 without any. What is lost is taken
/// for differing by more.
double share_within(const ProjectionDifference& difference, double sigmas);

/// A difference of one parameter, or of several that belong together, over the sigma of both.
struct NormalizedDifference {
  std::string name;
  double difference = 0.0;  ///< b minus a, in the parameter's unit; of several: the root of their summed squares
  double sigma = 0.0;       ///< root of both variances
  /// Several: root of the mean squared whitened difference. Where neither is uncertain NaN if they agree, else infinite.
  double sigmas = 0.0;
};

/// Two calibrations of the same cameras, side by side.
struct CalibrationComparison {
  SigmasFrom sigmas_from = SigmasFrom::kCorners;
  std::vector<ProjectionDifference> projections;  ///< camera by camera, range by range
  std::vector<NormalizedDifference> extrinsics;   ///< six of each camera after the first: camera_from_rig
  std::vector<NormalizedDifference> beams;        ///< `row,column` of those that both have
  /// In words: cameras, the laser, or more than a few of its beams, that only one has; rigs and grids that differ.
  std::vector<std::string> not_compared;
  std::vector<std::string> remarks;  ///< what was compared in part, in words

  bool agrees() const;  ///< all projections do
};

struct ComparisonOptions {
  std::vector<double> ranges_m{kInfinitelyFar};
  int columns = 40;  ///< cells along the image's width
  SigmasFrom sigmas_from = SigmasFrom::kCorners;
};

/// Compares the cameras of the same name; their models may differ. What no image tells is taken out first: of the two
/// sets of surroundings, which are not the same boards, the best fitting rotation and, at finite ranges, translation,
/// over the cells that both saw; where only one tells which it saw, as beside a simulated truth, over its. The sigmas
/// are those of differences after such a fit.
///
/// @throws Error(kBadInput) when no camera is in both, sizes of images differ, corners that were seen in common are too
///         few, or a covariance that is asked for is not there
/// Source: mrcal's projection difference, with the uncertainty of the same fit.
CalibrationComparison compare(const Calibration& a, const Calibration& b, const ComparisonOptions& options = {});

}  // namespace raybundle
