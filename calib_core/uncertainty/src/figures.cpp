// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "figures.hpp"

#include <algorithm>
#include <cmath>

#include "raybundle/uncertainty/image_cells.hpp"
#include "raybundle/uncertainty/stereo_depth.hpp"

namespace raybundle {
namespace {

constexpr double kDepthShare = 0.95;  // of the places or beams

// Pixels of a grid over the image whose rays lie within the required field.
std::vector<Eigen::Vector2d> places(const Requirement& requirement, const Camera& camera, int columns, Figure& figure) {
  std::vector<Eigen::Vector2d> pixels;
  const int rows = rows_of_square_cells(camera.size, columns);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Eigen::Vector2d pixel = middle_of_cell(camera.size, rows, columns, row, column);
      const auto ray = ray_from_pixel(camera, pixel);
      if (!ray) continue;
      const double angle = angle_off_axis(*ray);
      figure.reach_rad = std::max(figure.reach_rad, angle);
      if (requirement.field_rad && angle > *requirement.field_rad / 2) continue;
      pixels.push_back(pixel);
    }
  }
  return pixels;
}

struct Value {
  double value;
  Eigen::Vector2d pixel;
};

// The value that a share of all stays below, and where it stands; their root mean square.
void sum_up(std::vector<Value> values, double share, Figure& figure) {
  if (values.empty()) return;
  double squares = 0.0;
  for (const Value& each : values) squares += each.value * each.value;
  figure.rms = std::sqrt(squares / static_cast<double>(values.size()));
  std::ranges::sort(values, {}, &Value::value);
  const Value& chosen = values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
  figure.value = chosen.value;
  figure.worst = chosen.pixel;
}

bool is_meant(const Requirement& requirement, const RigCamera& camera) {
  return requirement.camera.empty() || requirement.camera == camera.name;
}

}  // namespace

double stated_beam_sigma(const LaserBeam& beam, double depth_m) {
  for (std::size_t d = 0; d < kStatedDepths_m.size(); ++d) {
    if (depth_m == kStatedDepths_m[d]) return beam.depths[d].sigma_m;
    if (d + 1 == kStatedDepths_m.size() || depth_m < kStatedDepths_m[d] || depth_m > kStatedDepths_m[d + 1]) continue;
    const double part = std::log(depth_m / kStatedDepths_m[d]) / std::log(kStatedDepths_m[d + 1] / kStatedDepths_m[d]);
    return std::pow(beam.depths[d].sigma_m, 1 - part) * std::pow(beam.depths[d + 1].sigma_m, part);
  }
  return std::nan("");
}

std::vector<Subject> subjects_of(const Requirement& requirement, const Calibration& calibration) {
  const std::vector<RigCamera>& cameras = calibration.cameras;
  if (cameras.empty()) return {};
  const bool pairs = requirement.quantity == Quantity::kDepth || requirement.quantity == Quantity::kBaseline;
  std::vector<Subject> subjects;
  for (int c = pairs ? 1 : 0; c < static_cast<int>(cameras.size()); ++c) {
    if (pairs && (is_meant(requirement, cameras[0]) || is_meant(requirement, cameras[c]))) {
      subjects.push_back({0, c, false, cameras[0].name + " and " + cameras[c].name});
    } else if (!pairs && is_meant(requirement, cameras[c])) {
      subjects.push_back({c, -1, false, cameras[c].name});
    }
  }
  if (requirement.quantity == Quantity::kDepth && calibration.laser && is_meant(requirement, cameras[0])) {
    subjects.push_back({0, -1, true, "the laser and " + cameras[0].name});
  }
  return subjects;
}

Figure figure_of_beams(const std::vector<double>& sigmas) {
  Figure figure;
  std::vector<Value> values;
  for (const double sigma : sigmas) {
    if (std::isfinite(sigma)) values.push_back({sigma, Eigen::Vector2d::Zero()});
  }
  sum_up(std::move(values), kDepthShare, figure);
  return figure;
}

Figure figure_of(const Requirement& requirement, const Subject& subject, const Calibration& calibration,
                 const Covariance& covariance, int columns) {
  const RigCamera& first = calibration.cameras[subject.first];
  Figure figure;
  std::vector<Value> values;
  if (subject.laser) {
    std::vector<double> sigmas;
    for (const LaserBeam& beam : calibration.laser->beams) {
      sigmas.push_back(stated_beam_sigma(beam, requirement.range_m));
    }
    return figure_of_beams(sigmas);
  }
  std::optional<ProjectionUncertainty> lens;
  if (requirement.quantity == Quantity::kProjection && !first.evidence) return figure;
  if (requirement.quantity == Quantity::kProjection) lens = projection_uncertainty(first, covariance);
  int unseen = 0;
  for (const Eigen::Vector2d& pixel : places(requirement, first.camera, columns, figure)) {
    double sigma = std::nan("");
    if (!lens) {
      sigma = stereo_depth(first, calibration.cameras[subject.second], covariance, pixel, requirement.range_m).sigma_m;
    } else if (const auto known = projection_covariance(*lens, pixel, requirement.range_m)) {
      sigma = largest_sigma(*known);
    }
    if (!std::isfinite(sigma)) continue;
    values.push_back({sigma, pixel});
    unseen += first.evidence && !first.evidence->covers(first.camera.size, pixel);
  }
  if (!values.empty()) figure.unseen_share = unseen / static_cast<double>(values.size());
  sum_up(std::move(values), lens ? 1.0 : kDepthShare, figure);
  return figure;
}

}  // namespace raybundle
