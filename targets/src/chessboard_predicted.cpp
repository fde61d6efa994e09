// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "chessboard.hpp"
#include "lattice.hpp"

namespace raybundle {
namespace {

/// Corners that are where they are predicted; `shift` 1 when the square outside of corner 0 is dark, 0 when bright.
std::vector<std::pair<int, Saddle>> refined(const cv::Mat& gray, const Chessboard& board,
                                            const std::vector<Observation>& predicted, int shift) {
  Lattice expected;
  const auto place_of = [&](int id) { return LatticePlace(id % board.columns + shift, id / board.columns); };
  for (const Observation& corner : predicted) {
    Saddle saddle;
    saddle.pixel = corner.pixel;
    expected.emplace(place_of(corner.point_id), saddle);
  }
  std::vector<std::pair<int, Saddle>> found;
  for (const Observation& corner : predicted) {
    if (const auto saddle = refined_on_lattice(gray, expected, place_of(corner.point_id), corner.pixel)) {
      found.emplace_back(corner.point_id, *saddle);
    }
  }
  return found;
}

}  // namespace

std::vector<Observation> refine_predicted_chessboard(const cv::Mat& gray, const Chessboard& board,
                                                     const std::vector<Observation>& predicted) {
  const cv::Mat& image = gray;
  std::vector<std::pair<int, Saddle>> found = refined(image, board, predicted, 1);
  if ((board.columns + board.rows) % 2 == 0 && 2 * found.size() < predicted.size()) {
    std::vector<std::pair<int, Saddle>> bright_first = refined(image, board, predicted, 0);  // either print is in use
    if (bright_first.size() > found.size()) found = std::move(bright_first);
  }
  if (found.empty()) return {};

  std::vector<double> contrasts;
  for (const auto& [id, saddle] : found) contrasts.push_back(saddle.contrast);
  std::ranges::nth_element(contrasts, contrasts.begin() + contrasts.size() / 2);
  const double faintest = 0.2 * contrasts[contrasts.size() / 2];
  std::vector<Observation> observations;
  for (const auto& [id, saddle] : found) {
    if (saddle.contrast >= faintest) observations.push_back({saddle.pixel, saddle.sigma_px, id});
  }
  std::ranges::sort(observations, {}, &Observation::point_id);
  return observations;
}

}  // namespace raybundle
