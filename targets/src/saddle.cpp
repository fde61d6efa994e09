// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "saddle.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace raybundle {
namespace {

// The model: grey = base + amplitude p + tone p² + (shade · r)(1 + p) / 2 with p = -erf(d_a / √2 blur) erf(d_b / √2
// blur), where d_a, d_b are signed distances from the two edges: a product of blurred steps, seen through a tone curve
// (the quadratic term: over-exposed squares grow) and light that changes over the window, bright squares more than dark
// ones.
enum Parameter { kX, kY, kAngleA, kAngleB, kLogBlur, kBase, kAmplitude, kTone, kShadeX, kShadeY, kParameters };
using Vector = Eigen::Matrix<double, kParameters, 1>;
using Matrix = Eigen::Matrix<double, kParameters, kParameters>;

constexpr double kLargestHalf_px = 11.0;  // larger windows cost time and bring lens curvature, not accuracy
constexpr double kNoise_grey = 2.5;       // noise against which the priors are weighed

/// erf(z / √2) and its derivative by linear interpolation; error below 1e-5.
struct BlurredStep {
  static constexpr double kEnd = 4.5;
  static constexpr int kPerUnit = 256;
  static constexpr int kSize = static_cast<int>(2 * kEnd * kPerUnit) + 2;
  std::array<float, kSize> value;
  std::array<float, kSize> slope;
  BlurredStep() {
    for (int i = 0; i < kSize; ++i) {
      const double z = static_cast<double>(i) / kPerUnit - kEnd;
      value[i] = static_cast<float>(std::erf(z * std::numbers::sqrt2 / 2));
      slope[i] = static_cast<float>(std::sqrt(2 / std::numbers::pi) * std::exp(-0.5 * z * z));
    }
  }
  void at(double z, double& step, double& step_wrt_z) const {
    const double place = (std::clamp(z, -kEnd, kEnd) + kEnd) * kPerUnit;
    const int i = static_cast<int>(place);
    const double f = place - i;
    step = (1 - f) * value[i] + f * value[i + 1];
    step_wrt_z = (1 - f) * slope[i] + f * slope[i + 1];
  }
};

struct Sample {
  double x, y;  // from the window's centre [px]
  double grey;
  double weight;
};

struct Fit {
  Vector parameters;
  Matrix information = Matrix::Zero();  // JᵀWJ with priors
  Matrix scatter = Matrix::Zero();      // JᵀW²J
  Vector gradient = Vector::Zero();
  double cost = 0;     // Σ w r² with priors
  double squares = 0;  // Σ w r²
  double weights = 0;
};

struct Priors {
  Vector mean = Vector::Zero();
  Vector weight = Vector::Zero();
};

/// Cost and normal equations at `parameters`.
Fit evaluate(const std::vector<Sample>& samples, const Vector& parameters, const Priors& priors, double bend_a,
             double bend_b) {
  static const BlurredStep blurred_step;
  Fit fit;
  fit.parameters = parameters;
  const double blur = std::exp(parameters[kLogBlur]);
  const Eigen::Vector2d along_a(std::cos(parameters[kAngleA]), std::sin(parameters[kAngleA]));
  const Eigen::Vector2d along_b(std::cos(parameters[kAngleB]), std::sin(parameters[kAngleB]));
  for (const Sample& sample : samples) {
    const double x = sample.x - parameters[kX];
    const double y = sample.y - parameters[kY];
    const double t_a = along_a.x() * x + along_a.y() * y;
    const double n_a = along_a.x() * y - along_a.y() * x;
    const double t_b = along_b.x() * x + along_b.y() * y;
    const double n_b = along_b.x() * y - along_b.y() * x;
    const double z_a = (n_a - 0.5 * bend_a * t_a * t_a) / blur;
    const double z_b = (n_b - 0.5 * bend_b * t_b * t_b) / blur;
    double step_a, slope_a, step_b, slope_b;
    blurred_step.at(z_a, step_a, slope_a);
    blurred_step.at(z_b, step_b, slope_b);
    const double p = -step_a * step_b;
    const double shade = parameters[kShadeX] * sample.x + parameters[kShadeY] * sample.y;
    const double model =
        parameters[kBase] + parameters[kAmplitude] * p + parameters[kTone] * p * p + 0.5 * shade * (1 + p);
    const double residual = sample.grey - model;
    const double model_wrt_p = parameters[kAmplitude] + 2 * parameters[kTone] * p + 0.5 * shade;
    const double wrt_z_a = -model_wrt_p * slope_a * step_b;
    const double wrt_z_b = -model_wrt_p * slope_b * step_a;

    Vector j;
    j[kX] =
        (wrt_z_a * (along_a.y() + bend_a * t_a * along_a.x()) + wrt_z_b * (along_b.y() + bend_b * t_b * along_b.x())) /
        blur;
    j[kY] = (wrt_z_a * (-along_a.x() + bend_a * t_a * along_a.y()) +
             wrt_z_b * (-along_b.x() + bend_b * t_b * along_b.y())) /
            blur;
    j[kAngleA] = wrt_z_a * (-t_a - bend_a * t_a * n_a) / blur;
    j[kAngleB] = wrt_z_b * (-t_b - bend_b * t_b * n_b) / blur;
    j[kLogBlur] = -(wrt_z_a * z_a + wrt_z_b * z_b);
    j[kBase] = 1;
    j[kAmplitude] = p;
    j[kTone] = p * p;
    j[kShadeX] = 0.5 * sample.x * (1 + p);
    j[kShadeY] = 0.5 * sample.y * (1 + p);
    const Vector weighted = sample.weight * j;
    fit.information.noalias() += weighted * j.transpose();
    fit.scatter.noalias() += weighted * weighted.transpose();
    fit.gradient += weighted * residual;
    fit.squares += sample.weight * residual * residual;
    fit.weights += sample.weight;
  }
  const Vector off = priors.mean - parameters;
  fit.information.diagonal() += priors.weight;
  fit.gradient += priors.weight.cwiseProduct(off);
  fit.cost = fit.squares + off.dot(priors.weight.cwiseProduct(off));
  return fit;
}

/// Levenberg-Marquardt from `start`; small and dense.
Fit minimise(const std::vector<Sample>& samples, const Vector& start, const Priors& priors, double bend_a,
             double bend_b) {
  Fit best = evaluate(samples, start, priors, bend_a, bend_b);
  double damping = 1e-3;
  for (int iteration = 0; iteration < 15; ++iteration) {
    Matrix damped = best.information;
    damped.diagonal() *= 1 + damping;
    Vector step = damped.ldlt().solve(best.gradient);
    if (!step.allFinite()) break;
    step[kLogBlur] = std::clamp(step[kLogBlur], -0.7, 0.7);
    const double move = step.head<2>().norm();
    Fit next = evaluate(samples, best.parameters + step, priors, bend_a, bend_b);
    const bool better = next.cost < best.cost;
    const bool settled = best.cost - next.cost < 1e-3 * best.cost && move < 2e-3;
    if (better) best = next;
    if (settled) break;
    damping = better ? 0.2 * damping : 10 * damping;
    if (damping > 1e4) break;
  }
  return best;
}

struct Shape {
  Eigen::Matrix2d window_from_pixel;  // the window is |u|, |v| < 1, or the unit disc when round
  bool round = false;
  double half_px = 0;  // the shortest half-width
  double bend_a = 0, bend_b = 0;
};

std::vector<Sample> samples_of(const cv::Mat& gray, const Eigen::Vector2d& centre, const Shape& shape) {
  const Eigen::Matrix2d pixel_from_window = shape.window_from_pixel.inverse();
  Eigen::Vector2d reach = pixel_from_window.cwiseAbs().rowwise().sum();
  if (shape.round) reach = pixel_from_window.rowwise().norm();
  const int left = std::max(0, static_cast<int>(std::ceil(centre.x() - reach.x())));
  const int right = std::min(gray.cols - 1, static_cast<int>(std::floor(centre.x() + reach.x())));
  const int top = std::max(0, static_cast<int>(std::ceil(centre.y() - reach.y())));
  const int bottom = std::min(gray.rows - 1, static_cast<int>(std::floor(centre.y() + reach.y())));
  std::vector<Sample> samples;
  samples.reserve(static_cast<std::size_t>(std::max(0, right - left + 1)) *
                  static_cast<std::size_t>(std::max(0, bottom - top + 1)));
  for (int y = top; y <= bottom; ++y) {
    const uchar* row = gray.ptr<uchar>(y);
    for (int x = left; x <= right; ++x) {
      const Eigen::Vector2d from_centre(x - centre.x(), y - centre.y());
      const Eigen::Vector2d at = shape.window_from_pixel * from_centre;
      const Eigen::Array2d fall = 1 - at.array().square();
      const double weight = shape.round ? 1 - at.squaredNorm() : std::min(fall.x(), fall.y()) <= 0 ? 0 : fall.prod();
      if (weight > 0.02) samples.push_back({from_centre.x(), from_centre.y(), static_cast<double>(row[x]), weight});
    }
  }
  return samples;
}

/// Start values of the linear parameters, from the samples' signs.
void set_levels(const std::vector<Sample>& samples, Vector& parameters) {
  double sum[2] = {0, 0}, weight[2] = {1e-9, 1e-9};
  for (const Sample& sample : samples) {
    const double side_a = std::cos(parameters[kAngleA]) * sample.y - std::sin(parameters[kAngleA]) * sample.x;
    const double side_b = std::cos(parameters[kAngleB]) * sample.y - std::sin(parameters[kAngleB]) * sample.x;
    const int bright = side_a * side_b < 0;
    sum[bright] += sample.weight * sample.grey;
    weight[bright] += sample.weight;
  }
  const double dark_level = sum[0] / weight[0];
  const double bright_level = sum[1] / weight[1];
  parameters[kBase] = 0.5 * (dark_level + bright_level);
  parameters[kAmplitude] = 0.5 * (bright_level - dark_level);
}

Saddle saddle_of(const Fit& fit, const Eigen::Vector2d& start, std::size_t samples) {
  Saddle saddle;
  const Vector& parameters = fit.parameters;
  saddle.pixel = start + parameters.head<2>();
  saddle.edge_a = {std::cos(parameters[kAngleA]), std::sin(parameters[kAngleA])};
  saddle.edge_b = {std::cos(parameters[kAngleB]), std::sin(parameters[kAngleB])};
  if (parameters[kAmplitude] < 0) saddle.edge_a = std::exchange(saddle.edge_b, -saddle.edge_a);
  saddle.contrast = 2 * std::abs(parameters[kAmplitude]);
  saddle.blur_px = std::exp(parameters[kLogBlur]);
  const double mean_square = fit.squares / fit.weights;
  saddle.misfit = std::sqrt(mean_square) / std::max(saddle.contrast, 1e-6);

  const double spare = std::max(0.2, 1.0 - static_cast<double>(kParameters) / static_cast<double>(samples));
  const double variance_grey = mean_square / spare + 1.0 / 12;  // never below the rounding to whole grey values
  const Matrix inverse = fit.information.ldlt().solve(Matrix::Identity());
  const Matrix covariance = inverse * fit.scatter * inverse;
  constexpr double kFloor_px = 0.01;  // pixel grid and model: what remains without noise
  saddle.sigma_px = std::sqrt(variance_grey * 0.5 * (covariance(kX, kX) + covariance(kY, kY)) + kFloor_px * kFloor_px);
  return saddle;
}

/// Both bright sectors are brighter than both dark ones, by a good part of the contrast: at the outer corner of a dark
/// square three sectors are bright, and a fit alone can make up for that.
bool sectors_alternate(const std::vector<Sample>& samples, const Vector& parameters, double blur) {
  constexpr double kLeastPart = 0.35;
  double sum[4] = {0, 0, 0, 0}, weight[4] = {1e-9, 1e-9, 1e-9, 1e-9};
  for (const Sample& sample : samples) {
    const double x = sample.x - parameters[kX];
    const double y = sample.y - parameters[kY];
    const double side_a = std::cos(parameters[kAngleA]) * y - std::sin(parameters[kAngleA]) * x;
    const double side_b = std::cos(parameters[kAngleB]) * y - std::sin(parameters[kAngleB]) * x;
    const int sector = 2 * (side_a * side_b < 0) + (side_a < 0);
    const double inside = sample.weight * std::min(1.0, std::min(std::abs(side_a), std::abs(side_b)) / blur);
    sum[sector] += inside * sample.grey;
    weight[sector] += inside;
  }
  const double dark[2] = {sum[0] / weight[0], sum[1] / weight[1]};
  const double bright[2] = {sum[2] / weight[2], sum[3] / weight[3]};
  const double sign = parameters[kAmplitude] < 0 ? -1 : 1;
  double least = 1e9;
  for (const double d : dark) {
    for (const double b : bright) least = std::min(least, sign * (b - d));
  }
  return least > kLeastPart * 0.5 * sign * (bright[0] + bright[1] - dark[0] - dark[1]);
}

bool convincing(const Saddle& saddle, const Eigen::Vector2d& start, const Shape& shape) {
  const Eigen::Vector2d moved = shape.window_from_pixel * (saddle.pixel - start);
  const double sine = std::abs(saddle.edge_a.x() * saddle.edge_b.y() - saddle.edge_a.y() * saddle.edge_b.x());
  return saddle.pixel.allFinite() && moved.cwiseAbs().maxCoeff() < 0.6 && saddle.contrast > 6 && saddle.misfit < 0.16 &&
         sine > 0.15 && saddle.sigma_px < 0.5 && saddle.blur_px < 1.2 * shape.half_px;
}

/// Fits the model; the window moves along when the corner turns out to lie off its centre.
std::optional<Saddle> fitted(const cv::Mat& gray, const Eigen::Vector2d& start, const Shape& shape, double angle_a,
                             double angle_b, double angle_sigma) {
  Eigen::Vector2d centre = start;
  Vector parameters = Vector::Zero();
  parameters[kAngleA] = angle_a;
  parameters[kAngleB] = angle_b;
  parameters[kLogBlur] = std::log(std::min(1.0, 0.5 * shape.half_px));
  for (int round = 0;; ++round) {
    const std::vector<Sample> samples = samples_of(gray, centre, shape);
    if (samples.size() < 16) return std::nullopt;
    if (round == 0) set_levels(samples, parameters);
    Priors priors;
    const auto expect = [&](int which, double mean, double sigma) {
      priors.mean[which] = mean;
      priors.weight[which] = kNoise_grey * kNoise_grey / (sigma * sigma);
    };
    const double amplitude = std::max(5.0, std::abs(parameters[kAmplitude]));
    expect(kAngleA, angle_a, angle_sigma);
    expect(kAngleB, angle_b, angle_sigma);
    expect(kLogBlur, std::log(0.9), 0.8);
    expect(kTone, 0, 0.5 * amplitude);
    expect(kShadeX, 0, 0.3 * amplitude / shape.half_px);
    expect(kShadeY, 0, 0.3 * amplitude / shape.half_px);
    const Fit fit = minimise(samples, parameters, priors, shape.bend_a, shape.bend_b);
    const Eigen::Vector2d moved = fit.parameters.head<2>();
    if (!moved.allFinite() || (centre + moved - start).norm() > 2 * kLargestHalf_px) return std::nullopt;
    const Saddle saddle = saddle_of(fit, centre, samples.size());
    if (round >= 2 || (shape.window_from_pixel * moved).cwiseAbs().maxCoeff() < 0.05) {
      if (!convincing(saddle, start, shape) || !sectors_alternate(samples, fit.parameters, saddle.blur_px)) {
        return std::nullopt;
      }
      return saddle;
    }
    if ((shape.window_from_pixel * (saddle.pixel - start)).cwiseAbs().maxCoeff() > 1) return std::nullopt;
    centre = saddle.pixel;
    parameters = fit.parameters;
    parameters.head<2>().setZero();
  }
}

bool border_is_near(const cv::Mat& gray, const Eigen::Vector2d& pixel) {
  constexpr double kMargin_px = 1.5;
  return !(pixel.x() >= kMargin_px && pixel.y() >= kMargin_px && pixel.x() <= gray.cols - 1 - kMargin_px &&
           pixel.y() <= gray.rows - 1 - kMargin_px);
}

}  // namespace

std::optional<Saddle> refine_saddle(const cv::Mat& gray, const Eigen::Vector2d& start, double radius_px) {
  if (border_is_near(gray, start)) return std::nullopt;
  const double radius = std::clamp(radius_px, 3.0, kLargestHalf_px);
  std::optional<SaddleRing> ring;
  for (const double part : {0.7, 0.5, 0.9}) {
    if ((ring = saddle_ring(gray, start, part * radius))) break;
  }
  if (!ring) return std::nullopt;
  Shape shape;
  shape.window_from_pixel = Eigen::Matrix2d::Identity() / radius;
  shape.round = true;
  shape.half_px = radius;
  return fitted(gray, start, shape, ring->angle_a, ring->angle_b, 0.3);
}

std::optional<Saddle> refine_saddle(const cv::Mat& gray, const Eigen::Vector2d& start, const SaddleWindow& window) {
  if (border_is_near(gray, start)) return std::nullopt;
  const double length_x = window.half_x.norm();
  const double length_y = window.half_y.norm();
  const double cross = window.half_x.x() * window.half_y.y() - window.half_x.y() * window.half_y.x();
  if (!(length_x > 0.8 && length_y > 0.8 && std::abs(cross) > 0.1 * length_x * length_y)) return std::nullopt;
  Eigen::Matrix2d pixel_from_window;
  pixel_from_window.col(0) = window.half_x * std::min(1.0, kLargestHalf_px / length_x);
  pixel_from_window.col(1) = window.half_y * std::min(1.0, kLargestHalf_px / length_y);
  Shape shape;
  shape.window_from_pixel = pixel_from_window.inverse();
  shape.half_px = std::min({length_x, length_y, kLargestHalf_px});
  shape.bend_a = window.bend_x;
  shape.bend_b = window.bend_y;
  const double angle_x = std::atan2(window.half_x.y(), window.half_x.x());
  const double angle_y = std::atan2(window.half_y.y(), window.half_y.x());
  return fitted(gray, start, shape, angle_x, angle_y, 0.2);
}

}  // namespace raybundle
