// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "laser_dots_fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace raybundle {
namespace {

constexpr int kParameters = 9;  // amplitude, x, y, three of the shape, three of the background
constexpr int kMostSteps = 16;
constexpr double kConverged = 1e-3;   // squared sigmas that a step changes the parameters by
constexpr double kScaleSigma = 0.02;  // relative, of the laser-off image's scale at one place
using Vector = Eigen::Matrix<double, kParameters, 1>;
using Matrix = Eigen::Matrix<double, kParameters, kParameters>;

struct Normal {
  Matrix matrix = Matrix::Zero();
  Vector right = Vector::Zero();
  double cost = 0;
};

// Parameters: amplitude, x, y, precision xx, xy, yy, and the background's: even, and slopes in x and y, or with a
// laser-off image the share of it that its scale is off by (the last is then not used).
struct Model {
  const SpotWindow& window;
  const GreyNoise& noise;
  const SpotShape& shape;

  Normal normal_at(const Vector& p) const;
  Vector prior_mean() const;
  Vector prior_weight() const;
};

Vector Model::prior_mean() const {
  Vector mean = Vector::Zero();
  mean.segment<3>(3) << shape.precision(0, 0), shape.precision(0, 1), shape.precision(1, 1);
  return mean;
}

Vector Model::prior_weight() const {
  Vector weight = Vector::Zero();
  const double sigma = shape.relative_sigma * shape.precision.trace() / 2;
  weight.segment<3>(3).setConstant(1 / (sigma * sigma));
  if (window.pair) weight.tail<2>() << 1 / (kScaleSigma * kScaleSigma), 1.0;
  return weight;
}

Normal Model::normal_at(const Vector& p) const {
  Normal normal;
  Vector row;
  for (std::size_t i = 0; i < window.size(); ++i) {
    const double x = window.x[i] - p[1], y = window.y[i] - p[2];
    const double u = p[3] * x + p[4] * y, v = p[4] * x + p[5] * y;
    const double bell = std::exp(-0.5 * (x * u + y * v)), unit = window.reflectance[i] * bell;
    const double light = p[0] * unit;
    const double slope_x = window.pair ? window.background[i] : window.x[i], slope_y = window.pair ? 0 : window.y[i];
    const double model = light + p[6] + p[7] * slope_x + p[8] * slope_y;
    // The background's own shot noise is in the variance already.
    const double weight = 1 / (window.variance[i] + noise.shot_variance * std::max(0.0, light) +
                               window.reflectance_variance * p[0] * p[0] * bell * bell);
    const double residual = window.signal[i] - model;
    row << unit, light * u, light * v, -0.5 * light * x * x, -light * x * y, -0.5 * light * y * y, 1, slope_x, slope_y;
    normal.cost += weight * residual * residual;
    normal.right += (weight * residual) * row;
    const Vector weighted = weight * row;
    for (int column = 0; column < kParameters; ++column) {
      normal.matrix.col(column).tail(kParameters - column) += row[column] * weighted.tail(kParameters - column);
    }
  }
  const Vector weight = prior_weight(), off = prior_mean() - p;
  normal.matrix.diagonal() += weight;
  normal.right += weight.cwiseProduct(off);
  normal.cost += weight.dot(off.cwiseAbs2());
  return normal;
}

bool sensible(const Vector& p, const SpotShape& shape) {
  const double expected = shape.precision.trace() / 2;
  const double determinant = p[3] * p[5] - p[4] * p[4];
  return p[3] > 0.02 * expected && p[5] > 0.02 * expected && determinant > 1e-3 * expected * expected &&
         p[3] < 9 * expected && p[5] < 9 * expected;
}

double grey_around(const SpotWindow& window) {
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < window.size(); ++i) {
    if (window.near[i]) continue;
    sum += window.signal[i];
    ++count;
  }
  return sum / std::max(1, count);
}

// Goodness of fit within three sigmas, where the spot's own misfit is.
void judge(const SpotWindow& window, const GreyNoise& noise, const Vector& p, SpotFit& fit) {
  double chi = 0, excess = 0;
  int count = 0;
  for (std::size_t i = 0; i < window.size(); ++i) {
    if (!window.near[i]) continue;
    const double x = window.x[i] - p[1], y = window.y[i] - p[2];
    const double full = p[0] * std::exp(-0.5 * (p[3] * x * x + 2 * p[4] * x * y + p[5] * y * y));
    const double light = window.reflectance[i] * full;
    const double slope_x = window.pair ? window.background[i] : window.x[i], slope_y = window.pair ? 0 : window.y[i];
    const double residual = window.signal[i] - light - p[6] - p[7] * slope_x - p[8] * slope_y;
    const double variance =
        window.variance[i] + noise.shot_variance * std::max(0.0, light) + window.reflectance_variance * full * full;
    chi += residual * residual / variance;
    excess += residual * residual - variance;
    ++count;
  }
  fit.goodness = chi / std::max(1.0, count - 6.0);
  fit.misfit = std::sqrt(std::max(0.0, excess / std::max(1, count))) / std::max(1e-9, std::abs(p[0]));
}

}  // namespace

double Spot::value(const Eigen::Vector2d& at) const {
  const Eigen::Vector2d d = at - pixel;
  return amplitude * std::exp(-0.5 * d.dot(precision * d));
}

SpotFit fit_spot(const SpotWindow& window, const Spot& start, const SpotShape& shape, const GreyNoise& noise) {
  const Model model{window, noise, shape};
  Vector p = Vector::Zero();
  p << start.amplitude, start.pixel.x() - window.origin.x(), start.pixel.y() - window.origin.y(), start.precision(0, 0),
      start.precision(0, 1), start.precision(1, 1), grey_around(window), 0, 0;
  SpotFit fit;
  fit.spot = start;
  if (window.size() < 2 * kParameters) return fit;
  Normal normal = model.normal_at(p);
  double damping = 1e-3;
  for (int step = 0; step < kMostSteps; ++step) {
    Matrix damped = normal.matrix;
    damped.diagonal() *= 1 + damping;
    const Eigen::LDLT<Matrix, Eigen::Lower> solver(damped);
    const Vector move = solver.solve(normal.right);
    const Vector next = p + move;
    const bool allowed = sensible(next, shape) && move.segment<2>(1).cwiseAbs().maxCoeff() < 3;
    const Normal after = allowed ? model.normal_at(next) : Normal();
    // Weights change with the model, so that costs compare only roughly near the minimum.
    if (allowed && after.cost <= 1.01 * normal.cost + 0.1) {
      fit.converged = move.dot(normal.right) < kConverged;
      // Faint spots make Gauss and Newton's steps too long: no faster while the cost does not fall.
      damping = after.cost <= normal.cost ? 0.1 * damping : std::max(0.1, 10 * damping);
      p = next;
      normal = after;
      if (fit.converged) break;
    } else {
      damping = std::max(1e-2, 10 * damping);
    }
  }
  normal.matrix.triangularView<Eigen::StrictlyUpper>() = normal.matrix.transpose();
  const Matrix covariance = normal.matrix.ldlt().solve(Matrix::Identity());
  fit.spot.pixel = window.origin + p.segment<2>(1);
  fit.spot.amplitude = p[0];
  fit.spot.precision << p[3], p[4], p[4], p[5];
  fit.covariance_px2 = covariance.block<2, 2>(1, 1);
  Eigen::Matrix4d given_shape = normal.matrix.bottomRightCorner<4, 4>();
  given_shape.row(0) << normal.matrix(0, 0), normal.matrix.row(0).tail<3>();
  given_shape.col(0) = given_shape.row(0).transpose();
  given_shape.bottomRightCorner<3, 3>() = normal.matrix.bottomRightCorner<3, 3>();
  fit.amplitude_sigma = std::sqrt(std::max(0.0, given_shape.inverse()(0, 0)));
  judge(window, noise, p, fit);
  return fit;
}

}  // namespace raybundle
