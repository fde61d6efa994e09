// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "grating_fit.hpp"

#include <Eigen/Dense>
#include <cmath>

namespace raybundle {
namespace {

constexpr int kParameters = 12;
constexpr std::size_t kFewestLines = 9;  // a grating has as many unknowns as two or three, and lines err
using Step = Eigen::Matrix<double, kParameters, 1>;

Grating moved(const Grating& grating, const Step& step) {
  Grating result = grating;
  result.rig_from_projector = perturbed(grating.rig_from_projector, step.head<6>());
  result.column_pitch += step[6];
  result.row_pitch += step[7];
  result.skew_rad += step[8];
  result.k1 += step[9];
  result.k2 += step[10];
  result.shift_m += step[11];
  return result;
}

// Offset at the line's own point as an angle from the projector, and slopes; nothing when an order does not exist.
std::optional<Eigen::VectorXd> residuals(const Grating& grating, const std::vector<OrderedLine>& lines) {
  Eigen::VectorXd result(4 * lines.size());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::optional<Line3> beam = beam_of_order(grating, lines[i].m, lines[i].n);
    if (!beam || beam->direction.dot(lines[i].line.direction) < 0.1) return std::nullopt;
    const Eigen::Vector4d motion = motion_between(lines[i].line, *beam);
    const double range = (lines[i].line.point - grating.rig_from_projector.translation).norm();
    result.segment<4>(static_cast<Eigen::Index>(4 * i)) << motion.head<2>() / std::max(range, 1e-3), motion.tail<2>();
  }
  return result;
}

// Differences from both sides; the steps are small against what the parameters move and large against rounding.
Eigen::MatrixXd jacobian(const Grating& grating, const std::vector<OrderedLine>& lines) {
  constexpr double kStep = 1e-6;
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(4 * lines.size()), kParameters);
  for (int k = 0; k < kParameters; ++k) {
    const Step step = kStep * Step::Unit(k);
    const auto ahead = residuals(moved(grating, step), lines);
    const auto behind = residuals(moved(grating, -step), lines);
    if (ahead && behind) result.col(k) = (*ahead - *behind) / (2 * kStep);
  }
  return result;
}

// Directions as an affine function of the orders: constant part is the axis, slopes are the steps.
std::optional<Grating> start(const std::vector<OrderedLine>& lines) {
  Eigen::MatrixXd orders(lines.size(), 3);
  Eigen::MatrixXd directions(lines.size(), 3);
  std::vector<Line3> beams;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    orders.row(static_cast<Eigen::Index>(i)) << 1.0, lines[i].m, lines[i].n;
    directions.row(static_cast<Eigen::Index>(i)) = lines[i].line.direction;
    beams.push_back(lines[i].line);
  }
  const auto solver = orders.colPivHouseholderQr();
  if (solver.rank() < 3) return std::nullopt;
  const Eigen::Matrix3d affine = solver.solve(directions);
  const Eigen::Vector3d axis = affine.row(0).normalized();
  const Eigen::Vector3d column = affine.row(1) - affine.row(1).dot(axis) * axis.transpose();
  const Eigen::Vector3d row = affine.row(2) - affine.row(2).dot(axis) * axis.transpose();
  Eigen::Matrix3d rotation;
  rotation << column.normalized(), axis.cross(column.normalized()), axis;
  Grating grating;
  grating.rig_from_projector = {Eigen::Quaterniond(rotation), point_nearest_to(beams)};
  grating.column_pitch = column.norm();
  grating.row_pitch = row.norm();
  grating.skew_rad = std::asin(std::clamp(row.normalized().dot(rotation.col(0)), -1.0, 1.0));
  if (row.dot(rotation.col(1)) < 0.0) grating.skew_rad = M_PI - grating.skew_rad;
  return grating;
}

}  // namespace

std::optional<GratingFit> fit_grating(const std::vector<OrderedLine>& lines) {
  constexpr int kMaxIterations = 60;
  if (lines.size() < kFewestLines) return std::nullopt;
  std::optional<Grating> grating = start(lines);
  if (!grating) return std::nullopt;
  std::optional<Eigen::VectorXd> error = residuals(*grating, lines);
  if (!error) return std::nullopt;
  double damping = 1e-3;
  for (int iteration = 0; iteration < kMaxIterations && damping < 1e8; ++iteration) {
    const Eigen::MatrixXd slopes = jacobian(*grating, lines);
    Eigen::MatrixXd normal = slopes.transpose() * slopes;
    normal.diagonal() *= 1.0 + damping;
    normal.diagonal().array() += 1e-14;
    const Step step = normal.ldlt().solve(-slopes.transpose() * *error);
    const Grating trial = moved(*grating, step);
    const std::optional<Eigen::VectorXd> trial_error = residuals(trial, lines);
    if (!trial_error || !(trial_error->squaredNorm() < error->squaredNorm())) {
      damping *= 10.0;
      continue;
    }
    const bool converged = trial_error->squaredNorm() > (1.0 - 1e-10) * error->squaredNorm();
    grating = trial;
    error = trial_error;
    damping = std::max(1e-12, damping * 0.1);
    if (converged) break;
  }
  return GratingFit{*grating, std::sqrt(error->squaredNorm() / static_cast<double>(2 * lines.size()))};
}

}  // namespace raybundle
