// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/wavelength.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>

#include "raybundle/geometry/quantile.hpp"
#include "raybundle/uncertainty/held_out_dots.hpp"

namespace raybundle {
namespace {

// Ten kelvins move the outermost dots by one or two pixels; a dot farther from all beams is none of them.
constexpr double kTolerance_px = 6.0;
constexpr double kStep = 1e-4;    // of the scale, for the derivative
constexpr double kOutlier = 4.0;  // robust standard deviations
constexpr int kFewestDots = 10;
constexpr int kMostIterations = 10;
constexpr double kLeastChange = 1e-9;  // far below what any dot shows; of exact dots sigma is nought

struct Row {
  Eigen::Vector2d residual;  // measured minus predicted, whitened
  Eigen::Vector2d slope;     // of the prediction with the scale, whitened
};

std::vector<Row> rows_at(const Calibration& calibration, double scale, const CalibrationProblem& problem,
                         const std::vector<std::optional<Rigid3>>& rig_from_target) {
  const auto explained = [&](double at) {
    Calibration moved = calibration;
    moved.laser = at_wavelength(*calibration.laser, at);
    return explain_dots(moved, problem, rig_from_target, kTolerance_px);
  };
  std::map<std::pair<int, int>, HeldOutDot> there;
  for (const HeldOutDot& dot : explained(scale + kStep)) there.emplace(std::pair{dot.view, dot.dot}, dot);
  std::vector<Row> rows;
  for (const HeldOutDot& dot : explained(scale)) {
    const auto moved = there.find({dot.view, dot.dot});
    if (moved == there.end() || moved->second.beam != dot.beam) continue;
    const Eigen::LLT<Eigen::Matrix2d> whitener(problem.views[dot.view].dots[dot.dot].covariance_px2);
    rows.push_back({whitener.matrixL().solve(dot.residual_px),
                    whitener.matrixL().solve(dot.residual_px - moved->second.residual_px) / kStep});
  }
  return rows;
}

// The change that half of the rows, each by the weight of its slope, want to exceed.
double median_change(const std::vector<Row>& rows) {
  std::vector<std::pair<double, double>> wanted;
  double total = 0.0, below = 0.0;
  for (const Row& row : rows) {
    const double slope = row.slope.norm();
    wanted.emplace_back(row.slope.dot(row.residual) / (slope * slope), slope);
    total += slope;
  }
  std::ranges::sort(wanted);
  return std::ranges::find_if(wanted, [&](const auto& w) { return (below += w.second) >= 0.5 * total; })->first;
}

// Leaves out the rows that lie far from what most of them agree on.
void keep_inliers(std::vector<Row>& rows) {
  const double change = median_change(rows);
  std::vector<double> distances;
  for (const Row& row : rows) distances.push_back((row.residual - change * row.slope).norm());
  const double limit = kOutlier * median(distances) / kRayleighMedian;
  std::erase_if(rows, [&](const Row& row) { return (row.residual - change * row.slope).norm() > limit; });
}

}  // namespace

std::optional<WavelengthEstimate> estimate_wavelength(const Calibration& calibration, const CalibrationProblem& problem,
                                                      const std::vector<std::optional<Rigid3>>& rig_from_target) {
  WavelengthEstimate estimate;
  estimate.scale = estimate.was = calibration.laser->grating->wavelength_scale;
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    std::vector<Row> rows = rows_at(calibration, estimate.scale, problem, rig_from_target);
    std::erase_if(rows, [](const Row& row) { return !(row.slope.squaredNorm() > 0.0); });
    if (static_cast<int>(rows.size()) < kFewestDots) return std::nullopt;
    keep_inliers(rows);
    double information = 0.0, wanted = 0.0, squares = 0.0;
    for (const Row& row : rows) {
      information += row.slope.squaredNorm();
      wanted += row.slope.dot(row.residual);
    }
    const double change = wanted / information;
    for (const Row& row : rows) squares += (row.residual - change * row.slope).squaredNorm();
    estimate.scale += change;
    estimate.dots = static_cast<int>(rows.size());
    estimate.sigma = std::sqrt(squares / (2.0 * estimate.dots - 1.0) / information);
    if (std::abs(change) < std::max(1e-3 * estimate.sigma, kLeastChange)) return estimate;
  }
  return std::nullopt;
}

}  // namespace raybundle
