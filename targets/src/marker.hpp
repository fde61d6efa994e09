// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/aruco/dictionary.hpp>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "marker_map.hpp"
#include "saddle.hpp"

namespace raybundle {

using Quad = std::array<Eigen::Vector2d, 4>;

/// A coded square that was read in an image.
struct Marker {
  int id = 0;
  Quad corners;  ///< [px], clockwise in the image from the top-left of the upright code; good to a pixel or so
};

struct MarkerSearch {
  std::vector<Marker> markers;
  std::vector<Quad> unread;  ///< dark quadrilaterals that carry no code of the dictionary
};

/// All markers of a dictionary.
MarkerSearch find_markers(const cv::Mat& gray, const cv::Ptr<cv::aruco::Dictionary>& dictionary, int border_bits);

/// Where the markers of a board stand: Quad of marker `id` on the board [m]; fewer quads than the dictionary has codes.
using MarkerLayout = std::vector<Quad>;

/// The markers that stand beside each other as the layout says: the largest group of neighbours that agree. Ids that
/// the layout does not have are left out. Nothing when most markers are elsewhere: markers of one row agree under many
/// wrong layouts.
std::vector<Marker> consistent_markers(const std::vector<Marker>& markers, const MarkerLayout& layout);

/// Bits of a marker that read wrong, as a share of those that lie in the image; 1 when more than half of the bits are out
/// of sight or the border is not darker than the code's bright bits.
///
/// @param corners  as of Marker
double misread_bits(const cv::Mat& gray, const Quad& corners, const cv::Ptr<cv::aruco::Dictionary>& dictionary, int id,
                    int border_bits);

/// Whether a quadrilateral carries a code of the dictionary, without any bit wrong.
bool reads_as(const cv::Mat& gray, const Quad& corners, const cv::Ptr<cv::aruco::Dictionary>& dictionary,
              int border_bits = 1);

/// What to do about images whose markers are read only when they are flipped.
inline constexpr const char* kMirrored = "the images are mirrored; take them as the camera does, not flipped";

/// The saddle of a board at a predicted place, or near it.
///
/// @param sector    window as for refine_saddle; the bright sector lies between half_x and half_y
/// @param reach_px  how far from the prediction it may be
/// @return          nothing when there is none whose edges and polarity are the board's
std::optional<Saddle> find_saddle(const cv::Mat& gray, const Eigen::Vector2d& predicted, const SaddleWindow& sector,
                                  double reach_px);

}  // namespace raybundle
