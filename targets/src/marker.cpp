// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "marker.hpp"
#include "grey_at.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace raybundle {
namespace {

constexpr double kReachPitches = 2.2;   // neighbours are compared up to this distance, in markers' pitches
constexpr double kAgreeShare = 0.4;     // of the distance between two markers: room for strong distortion
constexpr double kAgreeingShare = 0.6;  // of the markers that the board could have
constexpr double kEdgeCosine = 0.90;    // edges within 25°
constexpr double kWeakestContrast = 10.0;

Quad quad_of(const std::vector<cv::Point2f>& corners) {
  Quad quad;
  for (int k = 0; k < 4; ++k) quad[k] = {corners[k].x, corners[k].y};
  return quad;
}

Eigen::Vector2d centre_of(const Quad& quad) { return (quad[0] + quad[1] + quad[2] + quad[3]) / 4.0; }

std::optional<LocalPrediction> map_of(const Quad& from, const Eigen::Vector2d& origin, const Quad& to) {
  std::vector<Eigen::Vector2d> shifted;
  for (const Eigen::Vector2d& corner : from) shifted.emplace_back(corner - origin);
  return map_at_origin(shifted, {to.begin(), to.end()}, {1.0, 1.0, 1.0, 1.0});
}

// Whether marker b is where marker a says that it should be. The affine part of a's map only: the perspective of a few
// pixels is noise when it is stretched to a neighbour.
bool agree(const Marker& a, const Marker& b, const MarkerLayout& layout) {
  const Eigen::Vector2d centre = centre_of(layout[a.id]);
  const std::optional<LocalPrediction> map = map_of(layout[a.id], centre, a.corners);
  if (!map) return false;
  const Eigen::Vector2d expected = map->pixel_from_board * (centre_of(layout[b.id]) - centre);
  const Eigen::Vector2d seen = centre_of(b.corners) - centre_of(a.corners);
  if ((expected - seen).norm() > kAgreeShare * expected.norm()) return false;
  // And b is turned as a is.
  const Eigen::Vector2d side = map->pixel_from_board * (layout[b.id][1] - layout[b.id][0]);
  const Eigen::Vector2d seen_side = b.corners[1] - b.corners[0];
  return side.dot(seen_side) > 0.7 * side.norm() * seen_side.norm();
}

// Exact homography of a square with that many cells a side.
cv::Matx33d image_from_square(const Quad& corners, int cells) {
  const auto side = static_cast<float>(cells);
  const std::array<cv::Point2f, 4> square{{{0, 0}, {side, 0}, {side, side}, {0, side}}};
  std::array<cv::Point2f, 4> image;
  for (int k = 0; k < 4; ++k) {
    image[k] = {static_cast<float>(corners[k].x()), static_cast<float>(corners[k].y())};
  }
  return cv::getPerspectiveTransform(square.data(), image.data());
}

struct Cells {
  std::vector<double> code;  // grey values row by row; negative out of the image
  double threshold = 0.0;
  bool dark_border = false;  // nearly all of it
};

// Grey values at the cells' centres. Nothing when there is no contrast or no border in sight.
std::optional<Cells> sample(const cv::Mat& gray, const Quad& corners, int bits, int border_bits) {
  const int cells = bits + 2 * border_bits;
  const cv::Matx33d image_from_cells = image_from_square(corners, cells);
  Cells sampled;
  std::vector<double> border;
  for (int row = 0; row < cells; ++row) {
    for (int column = 0; column < cells; ++column) {
      const cv::Vec3d pixel = image_from_cells * cv::Vec3d(column + 0.5, row + 0.5, 1.0);
      if (!(pixel[2] > 0.0)) return std::nullopt;
      const double value = grey_at(gray, {pixel[0] / pixel[2], pixel[1] / pixel[2]});
      const int r = row - border_bits;
      const int c = column - border_bits;
      if (r >= 0 && c >= 0 && r < bits && c < bits) {
        sampled.code.push_back(value);
      } else if (value >= 0.0) {
        border.push_back(value);
      }
    }
  }
  if (border.empty()) return std::nullopt;
  std::ranges::sort(border);
  const double dark = border[border.size() / 2];
  const double bright = std::ranges::max(sampled.code);
  if (bright < dark + kWeakestContrast) return std::nullopt;
  sampled.threshold = 0.5 * (dark + bright);
  const auto light = std::ranges::count_if(border, [&](double value) { return value > sampled.threshold; });
  sampled.dark_border = light <= static_cast<std::ptrdiff_t>(border.size() / 10);
  return sampled;
}

// Whether a saddle's edges run along u and v, with the bright sector between them; v is clockwise of u.
bool runs_along(const Saddle& saddle, const Eigen::Vector2d& u, const Eigen::Vector2d& v) {
  return std::abs(saddle.edge_a.dot(u.normalized())) > kEdgeCosine &&
         std::abs(saddle.edge_b.dot(v.normalized())) > kEdgeCosine;
}

}  // namespace

MarkerSearch find_markers(const cv::Mat& gray, const cv::Ptr<cv::aruco::Dictionary>& dictionary, int border_bits) {
  const cv::Ptr<cv::aruco::DetectorParameters> parameters = cv::aruco::DetectorParameters::create();
  parameters->markerBorderBits = border_bits;
  parameters->minMarkerPerimeterRate = 40.0 / std::max(gray.cols, gray.rows);  // 10 px a side
  parameters->polygonalApproxAccuracyRate = 0.05;                              // sides of markers near the rim are bent
  std::vector<std::vector<cv::Point2f>> corners, rejected;
  std::vector<int> ids;
  cv::aruco::detectMarkers(gray, dictionary, corners, ids, parameters, rejected);
  MarkerSearch search;
  for (std::size_t i = 0; i < ids.size(); ++i) search.markers.push_back({ids[i], quad_of(corners[i])});
  for (const auto& quad : rejected) search.unread.push_back(quad_of(quad));
  return search;
}

std::vector<Marker> consistent_markers(const std::vector<Marker>& markers, const MarkerLayout& layout) {
  std::vector<Marker> known;
  for (const Marker& marker : markers) {
    if (marker.id < static_cast<int>(layout.size())) known.push_back(marker);
  }
  if (layout.size() < 2) return known;
  double pitch = (centre_of(layout[1]) - centre_of(layout[0])).norm();
  for (std::size_t i = 2; i < layout.size(); ++i) {
    pitch = std::min(pitch, (centre_of(layout[i]) - centre_of(layout[0])).norm());
  }
  // Connected groups under "each is where the other says".
  std::vector<std::size_t> group(known.size());
  for (std::size_t i = 0; i < known.size(); ++i) group[i] = i;
  const auto root = [&](std::size_t i) {
    while (group[i] != i) i = group[i];
    return i;
  };
  for (std::size_t i = 0; i < known.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double distance = (centre_of(layout[known[i].id]) - centre_of(layout[known[j].id])).norm();
      if (known[i].id == known[j].id || distance > kReachPitches * pitch) continue;
      if (agree(known[i], known[j], layout) && agree(known[j], known[i], layout)) group[root(i)] = root(j);
    }
  }
  std::vector<std::size_t> sizes(known.size(), 0);
  for (std::size_t i = 0; i < known.size(); ++i) ++sizes[root(i)];
  const auto largest = std::ranges::max_element(sizes);
  if (largest == sizes.end() || *largest < 2) return {};
  if (static_cast<double>(*largest) < kAgreeingShare * static_cast<double>(known.size())) return {};
  std::vector<Marker> best;
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (root(i) != static_cast<std::size_t>(largest - sizes.begin())) continue;
    if (std::ranges::none_of(best, [&](const Marker& other) { return other.id == known[i].id; })) {
      best.push_back(known[i]);
    }
  }
  return best;
}

bool reads_as(const cv::Mat& gray, const Quad& corners, const cv::Ptr<cv::aruco::Dictionary>& dictionary,
              int border_bits) {
  const std::optional<Cells> cells = sample(gray, corners, dictionary->markerSize, border_bits);
  if (!cells) return false;
  const int bits = dictionary->markerSize;
  cv::Mat code(bits, bits, CV_8U);
  for (int i = 0; i < bits * bits; ++i) {
    if (cells->code[i] < 0.0) return false;
    code.at<std::uint8_t>(i / bits, i % bits) = cells->code[i] > cells->threshold ? 1 : 0;
  }
  // Plain squares have no bits and are no codes.
  const int ones = cv::countNonZero(code);
  int id = 0;
  int rotation = 0;
  return ones > 1 && ones < bits * bits - 1 && cells->dark_border && dictionary->identify(code, id, rotation, 0.0);
}

double misread_bits(const cv::Mat& gray, const Quad& corners, const cv::Ptr<cv::aruco::Dictionary>& dictionary, int id,
                    int border_bits) {
  const int bits = dictionary->markerSize;
  const std::optional<Cells> cells = sample(gray, corners, bits, border_bits);
  if (!cells || !cells->dark_border) return 1.0;
  const cv::Mat code = cv::aruco::Dictionary::getBitsFromByteList(dictionary->bytesList.rowRange(id, id + 1), bits);
  int wrong = 0;
  int seen = 0;
  for (int i = 0; i < bits * bits; ++i) {
    if (cells->code[i] < 0.0) continue;
    ++seen;
    if ((cells->code[i] > cells->threshold) != (code.at<std::uint8_t>(i / bits, i % bits) != 0)) ++wrong;
  }
  return 2 * seen < bits * bits ? 1.0 : static_cast<double>(wrong) / seen;
}

std::optional<Saddle> find_saddle(const cv::Mat& gray, const Eigen::Vector2d& predicted, const SaddleWindow& sector,
                                  double reach_px) {
  // Clockwise as seen in the image is positive with y down.
  SaddleWindow window = sector;
  if (window.half_x.x() * window.half_y.y() - window.half_x.y() * window.half_y.x() < 0.0) {
    std::swap(window.half_x, window.half_y);
    std::swap(window.bend_x, window.bend_y);
  }
  const auto try_at = [&](const Eigen::Vector2d& start) -> std::optional<Saddle> {
    std::optional<Saddle> saddle = refine_saddle(gray, start, window);
    if (!saddle || (saddle->pixel - predicted).norm() > reach_px) return std::nullopt;
    if (!runs_along(*saddle, window.half_x, window.half_y)) return std::nullopt;
    return saddle;
  };
  if (std::optional<Saddle> saddle = try_at(predicted)) return saddle;
  // A window that is small beside the prediction's error: look around. The best fit counts.
  std::optional<Saddle> best;
  for (int i = -1; i <= 1; ++i) {
    for (int j = -1; j <= 1; ++j) {
      const Eigen::Vector2d offset = 0.8 * (i * window.half_x + j * window.half_y);
      if ((i == 0 && j == 0) || offset.norm() > reach_px) continue;
      const std::optional<Saddle> saddle = try_at(predicted + offset);
      if (saddle && (!best || saddle->misfit < best->misfit)) best = saddle;
    }
  }
  return best;
}

}  // namespace raybundle
