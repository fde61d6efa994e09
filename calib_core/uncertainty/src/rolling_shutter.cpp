// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/rolling_shutter.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "pose_information.hpp"

namespace raybundle {
namespace {

constexpr Eigen::Index kFewestCorners = 20;  // 40 residuals for at most 12 unknowns

// A view's whitened residual at the solution, and what could explain it.
struct Explanations {
  Eigen::VectorXd residual;
  Eigen::MatrixXd pose, by_row, by_column, bend;
  double sigma_px = 1.0;  // that the residual was whitened by, root mean square
};

// The pose's columns times when each corner was exposed: 0 in the middle, in units of `length` pixels.
Eigen::MatrixXd timed(const Eigen::MatrixXd& pose, const Eigen::VectorXd& place, int length) {
  const Eigen::VectorXd time = (place.array() - place.mean()) / length;
  Eigen::MatrixXd result = pose;
  for (Eigen::Index i = 0; i < time.size(); ++i) result.middleRows<2>(2 * i) *= time[i];
  return result;
}

std::optional<Explanations> explanations_of(const Calibration& calibration, const ViewData& view, const Rigid3& pose) {
  const RigCamera& camera = calibration.cameras[view.camera];
  const BoardShape& shape = calibration.targets[view.target].shape;
  const ViewPoint point{camera.camera.parameters.data(), camera.camera_from_rig, pose, shape.sags()};
  ViewBlock block;
  if (!linearize_view(view, point, {.with_shape = true}, block)) return std::nullopt;
  const Eigen::Index rows = 2 * view.pixel.rows();
  Explanations all;
  all.residual = block.residual.head(rows);
  all.pose = block.wrt_rig_from_target.topRows(rows);
  // Where the corners are predicted: measured places would let their own noise explain the residuals.
  Eigen::MatrixX2d pixels = view.pixel;
  for (Eigen::Index i = 0; i < pixels.rows(); ++i) {
    pixels.row(i) += all.residual.segment<2>(2 * i).transpose() / view.inverse_sigma[i];
  }
  all.by_row = timed(all.pose, pixels.col(1), camera.camera.size.height);
  all.by_column = timed(all.pose, pixels.col(0), camera.camera.size.height);
  all.bend = block.wrt_shape.topRows(rows);
  all.sigma_px = 1.0 / std::sqrt(view.inverse_sigma.square().mean());
  return all;
}

// What is left of the residual when all these columns explain it.
struct Fit {
  double chi2 = 0.0;
  double freedom = 1.0;
  double rms_px(double sigma_px) const { return sigma_px * std::sqrt(2.0 * chi2 / freedom); }
};

Fit fit(const Explanations& all, std::initializer_list<const Eigen::MatrixXd*> parts) {
  Eigen::Index columns = 0;
  for (const Eigen::MatrixXd* part : parts) columns += part->cols();
  Eigen::MatrixXd by_all(all.residual.size(), columns);
  columns = 0;
  for (const Eigen::MatrixXd* part : parts) {
    by_all.middleCols(columns, part->cols()) = *part;
    columns += part->cols();
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(by_all);
  Fit result;
  result.chi2 = (all.residual - by_all * qr.solve(all.residual)).squaredNorm();
  result.freedom = static_cast<double>(all.residual.size() - qr.rank());
  return result;
}

// An F statistic as the quantile of a normal distribution. Source: Paulson 1942, An approximate normalization of the
// analysis of variance distribution.
double normal_from_f(double f, double numerator, double denominator) {
  const double a = 2.0 / (9.0 * numerator), b = 2.0 / (9.0 * denominator), root = std::cbrt(f);
  return ((1.0 - b) * root - (1.0 - a)) / std::sqrt(b * root * root + a);
}

// Whether more columns explain what chance does not.
bool beyond_chance(const Fit& without, const Fit& with) {
  const double unknowns = without.freedom - with.freedom;
  if (!(unknowns > 0.0 && with.chi2 > 0.0)) return false;
  const double f = (without.chi2 - with.chi2) / unknowns / (with.chi2 / with.freedom);
  return normal_from_f(f, unknowns, with.freedom) > kRowTimingSigmas;
}

RowTiming timing_of(const Explanations& all, int view) {
  const Fit still = fit(all, {&all.pose}), by_rows = fit(all, {&all.pose, &all.by_row});
  const Fit by_columns = fit(all, {&all.pose, &all.by_column});
  const Fit bend = fit(all, {&all.pose, &all.bend});
  // For errors of an unknown size, twice the logarithm of the ratio of likelihoods.
  const auto gain = [&](const Fit& of, const Fit& over) {
    return static_cast<double>(all.residual.size()) * std::log(over.chi2 / of.chi2);
  };
  const Fit& best = by_columns.chi2 < bend.chi2 ? by_columns : bend;
  return {view,
          still.rms_px(all.sigma_px),
          by_rows.rms_px(all.sigma_px),
          best.rms_px(all.sigma_px),
          beyond_chance(still, by_rows) && gain(by_rows, best) > kRowTimingGain,
          beyond_chance(still, by_columns) && gain(by_columns, by_rows) > kRowTimingGain};
}

}  // namespace

std::vector<RowTiming> row_timings(const CalibrationProblem& problem, const CalibrationResult& result, int camera) {
  const std::vector<RigCamera>& calibrated = result.calibration.cameras;
  const auto index = std::ranges::find(calibrated, problem.cameras[camera].name, &RigCamera::name) - calibrated.begin();
  std::vector<RowTiming> timings;
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    if (problem.views[v].camera != camera || result.views[v].pose < 0) continue;
    const ViewData view = used_corners(problem, result, v, static_cast<int>(index));
    if (view.pixel.rows() < kFewestCorners) continue;
    const auto all = explanations_of(result.calibration, view, result.poses[view.pose].rig_from_target);
    if (all) timings.push_back(timing_of(*all, v));
  }
  return timings;
}

bool is_rolling(const std::vector<RowTiming>& timings) {
  constexpr int kFewestViews = 3, kTimesColumns = 4;
  const auto rows = std::ranges::count_if(timings, &RowTiming::rows);
  return rows >= kFewestViews && rows > kTimesColumns * std::ranges::count_if(timings, &RowTiming::columns);
}

}  // namespace raybundle
