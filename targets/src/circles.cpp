// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "circles.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>

#include "circle_lattice.hpp"
#include "ellipse.hpp"
#include "marker_map.hpp"

namespace raybundle {
namespace {

constexpr double kNeighbourhood = 2.3;    // spacings: about five by five circles
constexpr double kWidest = 3.5;           // in the corners of grids whose rows are farther apart
constexpr int kFewestNeighbours = 7;      // a quadratic map has six terms
constexpr double kFarthestShare = 0.25;   // of the spacing, from the predicted place
constexpr double kRadiusTolerance = 0.3;  // of a circle's radius against the median
constexpr double kShiftError = 0.1;       // of the centre's shift: what the local map does not tell

CirclePattern pattern_of(const Circles& board) {
  CirclePattern pattern;
  pattern.spacing_m = board.spacing_m;
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      pattern.cells.emplace_back(column, row);
      pattern.x_in_board.emplace_back(column * board.spacing_m, row * board.spacing_m);
    }
  }
  return pattern;
}

// On the lattice of the two diagonals to the next row.
CirclePattern pattern_of(const AsymmetricCircles& board) {
  const int shift = board.first_row_shifted ? 1 : 0;
  CirclePattern pattern;
  pattern.spacing_m = board.nearest_m();
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      const int x = 2 * column + (row + shift) % 2;
      pattern.cells.emplace_back((x + row - shift) / 2, (row - x + shift) / 2);
      pattern.x_in_board.emplace_back(x * board.spacing_m, row * board.between_rows_m());
    }
  }
  return pattern;
}

/// Quadratic map from board to image around a point, and what it does to a circle's centre.
struct CentreShift {
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();  // of the ellipse's centre from the centre's image
  double radius_m = 0.0;
};

// With f = f0 + J u + u'Hu/2 the centroid of the image of a disc of radius r lies at f0 + r²/4 (tr H / 2 + J grad log
// det J), to second order in r; for a perspective map that is the centre of the ellipse.
std::optional<CentreShift> shift_at(const std::map<int, Eigen::Vector2d>& pixels, const CirclePattern& pattern, int id,
                                    const Eigen::Matrix2d& shape) {
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 2> right = Eigen::Matrix<double, 6, 2>::Zero();
  const auto place_of = [&](int other) -> Eigen::Vector2d {
    return (pattern.x_in_board[other] - pattern.x_in_board[id]) / pattern.spacing_m;
  };
  const auto within = [&](double reach) {
    return std::ranges::count_if(pixels, [&](const auto& entry) { return place_of(entry.first).norm() <= reach; });
  };
  const double reach = within(kNeighbourhood) >= kFewestNeighbours ? kNeighbourhood : kWidest;
  if (within(reach) < kFewestNeighbours) return std::nullopt;
  for (const auto& [other, pixel] : pixels) {
    const Eigen::Vector2d u = place_of(other);
    if (u.norm() > reach) continue;
    Eigen::Matrix<double, 6, 1> terms;
    terms << 1.0, u.x(), u.y(), 0.5 * u.x() * u.x(), u.x() * u.y(), 0.5 * u.y() * u.y();
    const double weight = std::exp(-0.3 * u.squaredNorm());
    normal += weight * terms * terms.transpose();
    right += weight * terms * (pixel - pixels.at(id)).transpose();
  }
  const Eigen::Matrix<double, 6, 2> map = normal.ldlt().solve(right);
  if (!map.allFinite()) return std::nullopt;
  Eigen::Matrix2d jacobian;
  jacobian << map(1, 0), map(2, 0), map(1, 1), map(2, 1);
  const double determinant = jacobian.determinant();
  if (!(std::abs(determinant) > 1e-9)) return std::nullopt;
  const double radius2 = std::sqrt(shape.determinant()) / std::abs(determinant);  // in spacings
  Eigen::Matrix2d by_x, by_y;                                                     // derivatives of the Jacobian
  by_x << map(3, 0), map(4, 0), map(3, 1), map(4, 1);
  by_y << map(4, 0), map(5, 0), map(4, 1), map(5, 1);
  const Eigen::Matrix2d inverse = jacobian.inverse();
  const Eigen::Vector2d log_slope((inverse * by_x).trace(), (inverse * by_y).trace());
  const Eigen::Vector2d laplacian = (map.row(3) + map.row(5)).transpose();
  return CentreShift{0.25 * radius2 * (0.5 * laplacian + jacobian * log_slope), std::sqrt(radius2) * pattern.spacing_m};
}

// Centres of the printed circles from the ellipses; circles of another size are none.
std::vector<Observation> centres_of(const std::map<int, Ellipse>& ellipses, const CirclePattern& pattern,
                                    const std::map<int, Eigen::Vector2d>& map_pixels) {
  std::map<int, CentreShift> shifts;
  std::vector<double> radii;
  for (const auto& [id, ellipse] : ellipses) {
    if (const auto shift = shift_at(map_pixels, pattern, id, ellipse.shape)) {
      shifts[id] = *shift;
      radii.push_back(shift->radius_m);
    }
  }
  if (radii.empty()) return {};
  std::ranges::nth_element(radii, radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2));
  const double radius_m = radii[radii.size() / 2];
  std::vector<Observation> centres;
  for (const auto& [id, shift] : shifts) {
    if (std::abs(shift.radius_m - radius_m) > kRadiusTolerance * radius_m) continue;
    const Ellipse& ellipse = ellipses.at(id);
    const double sigma = std::hypot(ellipse.sigma_px, kShiftError * shift.shift_px.norm());
    centres.push_back({ellipse.centre - shift.shift_px, sigma, id});
  }
  return centres;
}

std::vector<Observation> refine_near(const cv::Mat& gray, const CirclePattern& pattern,
                                     const std::map<int, Eigen::Vector2d>& predicted) {
  MarkerMap map;
  for (const auto& [id, pixel] : predicted) map.add(pattern.x_in_board[id], pixel, 1.0);
  std::map<int, Ellipse> ellipses;
  for (const auto& [id, pixel] : predicted) {
    const auto local = map.predict(pattern.x_in_board[id], pattern.spacing_m);
    if (!local) continue;
    const Eigen::Matrix2d& stretch = local->pixel_from_board;
    const double step = pattern.spacing_m * std::min(stretch.col(0).norm(), stretch.col(1).norm());
    const auto rough = find_ellipse_at(gray, pixel, 0.6 * pattern.spacing_m * stretch.norm());
    if (!rough) continue;
    const auto fine = refine_ellipse(gray, *rough);
    if (fine && (fine->centre - pixel).norm() < kFarthestShare * step) ellipses[id] = *fine;
  }
  return centres_of(ellipses, pattern, predicted);
}

Detection detect_pattern(const cv::Mat& gray, const CirclePattern& pattern) {
  Detection detection;
  const int longest = std::max(gray.cols, gray.rows);
  // The circles' size is not known: windows from large to small, until the whole grid stands out.
  for (const int part : {12, 30, 5, 70}) {
    const int block = std::max(7, longest / part) | 1;
    const std::vector<Ellipse> rough = find_ellipses(gray, block);
    CircleMatch match = match_circles(rough, pattern);
    if (detection.hint.empty()) detection.hint = match.hint;
    std::map<int, Ellipse> ellipses;
    std::map<int, Eigen::Vector2d> pixels;
    for (const auto& [id, index] : match.ellipse_of) {
      const auto fine = refine_ellipse(gray, rough[index]);
      if (!fine) continue;
      ellipses[id] = *fine;
      pixels[id] = fine->centre;
    }
    detection.observations = centres_of(ellipses, pattern, pixels);
    if (!detection.observations.empty()) {
      detection.hint.clear();
      break;
    }
  }
  return detection;
}

std::map<int, Eigen::Vector2d> by_id(const std::vector<Observation>& observations) {
  std::map<int, Eigen::Vector2d> pixels;
  for (const Observation& observation : observations) pixels[observation.point_id] = observation.pixel;
  return pixels;
}

}  // namespace

Detection detect_circles(const cv::Mat& gray, const Circles& board) { return detect_pattern(gray, pattern_of(board)); }

Detection detect_circles(const cv::Mat& gray, const AsymmetricCircles& board) {
  Detection detection = detect_pattern(gray, pattern_of(board));
  if (detection.observations.empty() && !detection.hint.empty()) {
    AsymmetricCircles mirrored = board;
    mirrored.first_row_shifted = !board.first_row_shifted;
    if (!detect_pattern(gray, pattern_of(mirrored)).observations.empty()) {
      detection.hint = std::string("the board's mirror image is seen: try first_row_shifted = ") +
                       (mirrored.first_row_shifted ? "true" : "false");
    }
  }
  return detection;
}

std::vector<Observation> refine_predicted_circles(const cv::Mat& gray, const Circles& board,
                                                  const std::vector<Observation>& predicted) {
  return refine_near(gray, pattern_of(board), by_id(predicted));
}

std::vector<Observation> refine_predicted_circles(const cv::Mat& gray, const AsymmetricCircles& board,
                                                  const std::vector<Observation>& predicted) {
  return refine_near(gray, pattern_of(board), by_id(predicted));
}

}  // namespace raybundle
