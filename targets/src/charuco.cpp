// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "charuco.hpp"

#include <algorithm>
#include <map>
#include <opencv2/core.hpp>

#include "board_dictionary.hpp"
#include "marker_map.hpp"

namespace raybundle {
namespace {

constexpr double kMarkerWeight = 0.1;  // a marker's corner is good to about a pixel
constexpr double kReachSquares = 1.6;  // corners are predicted from known points up to this distance
constexpr double kWindowShare = 1.2;   // half window over the gap between marker and square
constexpr double kSmallestWindow_px = 3.0;
constexpr double kFarthestShare = 0.2;  // of a square, from the predicted place
constexpr int kFewestCorners = 4;

struct Corner {
  int column = 0;
  int row = 0;
};

bool is_white(const Charuco& board, int column, int row) {
  const int shift = board.legacy && board.rows % 2 == 0 ? 1 : 0;
  return (column + row + shift) % 2 == 1;
}

Eigen::Vector2d place_of(const Charuco& board, const Corner& corner) {
  return {corner.column * board.square_m, corner.row * board.square_m};
}

// The saddle near a predicted corner, when it is there with the right polarity.
std::optional<Saddle> refine_corner(const cv::Mat& gray, const Charuco& board, const Corner& corner,
                                    const LocalPrediction& prediction) {
  const Eigen::Vector2d step_x = prediction.pixel_from_board.col(0) * board.square_m;
  const Eigen::Vector2d step_y = prediction.pixel_from_board.col(1) * board.square_m;
  const double shorter = std::min(step_x.norm(), step_y.norm());
  if (shorter < 2.0 * kSmallestWindow_px) return std::nullopt;
  const double gap = kWindowShare * 0.5 * (board.square_m - board.marker_m) / board.square_m;
  const double share = std::clamp(std::max(gap, kSmallestWindow_px / shorter), 0.0, 0.7);
  // Corner (0, 0) has square (0, 0) to its top left.
  const double towards_white = is_white(board, corner.column, corner.row) ? 1.0 : -1.0;
  const SaddleWindow window{share * step_x, share * towards_white * step_y};
  return find_saddle(gray, prediction.pixel, window, kFarthestShare * shorter);
}

// Corner after corner, each predicted from what is known around it, until no more is found.
std::map<int, Saddle> grow(const cv::Mat& gray, const Charuco& board, const std::vector<Marker>& markers) {
  const MarkerLayout layout = charuco_layout(board);
  MarkerMap map;
  for (const Marker& marker : markers) {
    for (int k = 0; k < 4; ++k) map.add(layout[marker.id][k], marker.corners[k], kMarkerWeight);
  }
  std::map<int, Saddle> found;
  for (bool progress = true; progress;) {
    std::vector<std::pair<int, Saddle>> fresh;
    for (int row = 0; row < board.rows - 1; ++row) {
      for (int column = 0; column < board.columns - 1; ++column) {
        const int id = row * (board.columns - 1) + column;
        if (found.contains(id)) continue;
        const Corner corner{column, row};
        const auto prediction = map.predict(place_of(board, corner), kReachSquares * board.square_m);
        if (!prediction) continue;
        if (const auto saddle = refine_corner(gray, board, corner, *prediction)) fresh.emplace_back(id, *saddle);
      }
    }
    for (const auto& [id, saddle] : fresh) {
      map.add(place_of(board, {id % (board.columns - 1), id / (board.columns - 1)}), saddle.pixel, 1.0);
      found.emplace(id, saddle);
    }
    progress = !fresh.empty();
  }
  return found;
}

cv::Mat upright_image(const cv::Mat& gray, const Charuco& board) {
  if (!board.inverted) return gray;
  cv::Mat inverse;
  cv::bitwise_not(gray, inverse);
  return inverse;
}

}  // namespace

// Markers stand on the white squares, numbered row by row; y points down and (0, 0) is the first inner corner.
MarkerLayout charuco_layout(const Charuco& board) {
  MarkerLayout layout;
  const double margin = 0.5 * (board.square_m - board.marker_m);
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      if (!is_white(board, column, row)) continue;
      const Eigen::Vector2d corner((column - 1) * board.square_m + margin, (row - 1) * board.square_m + margin);
      const double side = board.marker_m;
      layout.push_back({corner, corner + Eigen::Vector2d(side, 0), corner + Eigen::Vector2d(side, side),
                        corner + Eigen::Vector2d(0, side)});
    }
  }
  return layout;
}

Detection detect_charuco(const cv::Mat& gray, const Charuco& board) {
  const cv::Mat upright = upright_image(gray, board);
  const MarkerSearch search = find_markers(upright, dictionary_named(board.dictionary), 1);
  const std::vector<Marker> markers = consistent_markers(search.markers, charuco_layout(board));
  Detection detection;
  for (const auto& [id, saddle] : grow(upright, board, markers)) {
    detection.observations.push_back({saddle.pixel, saddle.sigma_px, id});
  }
  if (detection.observations.size() < kFewestCorners) {
    detection.observations.clear();
    detection.hint = charuco_hint(upright, board, search);
  }
  return detection;
}

std::vector<Observation> refine_predicted_charuco(const cv::Mat& gray, const Charuco& board,
                                                  const std::vector<Observation>& predicted) {
  const cv::Mat upright = upright_image(gray, board);
  const int columns = board.columns - 1;
  MarkerMap map;
  for (const Observation& point : predicted) {
    map.add(place_of(board, {point.point_id % columns, point.point_id / columns}), point.pixel, 1.0);
  }
  std::vector<Observation> accepted;
  for (const Observation& point : predicted) {
    const Corner corner{point.point_id % columns, point.point_id / columns};
    auto prediction = map.predict(place_of(board, corner), board.square_m);
    if (!prediction) continue;
    prediction->pixel = point.pixel;
    if (const auto saddle = refine_corner(upright, board, corner, *prediction)) {
      accepted.push_back({saddle->pixel, saddle->sigma_px, point.point_id});
    }
  }
  std::ranges::sort(accepted, {}, &Observation::point_id);
  return accepted;
}

}  // namespace raybundle
