// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "laser_dots_gates.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

namespace raybundle {
namespace {

constexpr double kSaturatedSigmas = 2.0;
constexpr double kClippedSigmas = 2.5;
constexpr double kDoubleSigmas = 2.5;  // closer, the sum of two spots has one maximum, or two that hardly show
constexpr double kMostGoodness = 3.0;  // times the noise's variance, and
constexpr double kMostMisfit = 0.15;   // of the amplitude: both together are no spot
constexpr double kWider = 1.35;        // times the usual width: two spots, or none
constexpr double kNarrower = 0.55;     // times the usual width: a hot pixel

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace

double mean_sigma(const Eigen::Matrix2d& precision) {
  return std::pow(std::max(1e-12, precision.determinant()), -0.25);
}

SpotShape usual_shape(const std::vector<SpotCandidate>& candidates, const SpotShape& otherwise) {
  std::array<std::vector<double>, 3> entries;
  for (const SpotCandidate& candidate : candidates) {
    if (candidate.fate != SpotFate::kGood) continue;
    const Eigen::Matrix2d& precision = candidate.fit.spot.precision;
    entries[0].push_back(precision(0, 0));
    entries[1].push_back(precision(0, 1));
    entries[2].push_back(precision(1, 1));
  }
  if (entries[0].size() < 5) return otherwise;
  SpotShape shape;
  const double cross = median(entries[1]);
  shape.precision << median(entries[0]), cross, cross, median(entries[2]);
  double scatter = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    std::vector<double> deviations = entries[k];
    const double middle = median(entries[k]);
    for (double& value : deviations) value = std::abs(value - middle);
    scatter = std::max(scatter, 1.48 * median(deviations));
  }
  // The noise of single fits is part of the scatter: the prior errs on the side of too weak.
  shape.relative_sigma = std::clamp(scatter / (shape.precision.trace() / 2), 0.1, 0.5);
  return shape;
}

bool is_saturated(const DotImages& images, const Eigen::Vector2d& pixel, double sigma_px) {
  const double far = kSaturatedSigmas * sigma_px;
  for (int y = std::max(0, static_cast<int>(std::ceil(pixel.y() - far)));
       y <= std::min(images.on.rows - 1, static_cast<int>(std::floor(pixel.y() + far))); ++y) {
    for (int x = std::max(0, static_cast<int>(std::ceil(pixel.x() - far)));
         x <= std::min(images.on.cols - 1, static_cast<int>(std::floor(pixel.x() + far))); ++x) {
      if (images.on.at<float>(y, x) > static_cast<float>(images.full_scale)) return true;
    }
  }
  return false;
}

bool is_clipped(const DotImages& images, const Eigen::Vector2d& pixel, double sigma_px) {
  const double far = kClippedSigmas * sigma_px;
  return pixel.x() < far - 0.5 || pixel.y() < far - 0.5 || pixel.x() > images.on.cols - 0.5 - far ||
         pixel.y() > images.on.rows - 0.5 - far;
}

SpotFate fate_of(const SpotFit& fit, const SpotShape& usual, bool pair, const Eigen::Vector2d& peak,
                 const DotOptions& options) {
  const double sigma = mean_sigma(usual.precision);
  const double significance = fit.spot.amplitude / fit.amplitude_sigma;
  if (!(significance >= options.least_significance)) return SpotFate::kFaint;
  if (!fit.converged || (fit.spot.pixel - peak).norm() > 1 + sigma) return pair ? SpotFate::kFaint : SpotFate::kOnEdge;
  if (fit.goodness > kMostGoodness && fit.misfit > kMostMisfit) return pair ? SpotFate::kDoubled : SpotFate::kOnEdge;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> own(fit.spot.precision);
  if (own.eigenvalues()[1] > std::pow(options.most_elongation, 2) * own.eigenvalues()[0]) return SpotFate::kStreak;
  // Widths relative to the usual shape's, longest first.
  const Eigen::LLT<Eigen::Matrix2d> root(usual.precision);
  const Eigen::Matrix2d left = root.matrixL().solve(fit.spot.precision);
  const Eigen::Matrix2d relative = root.matrixL().solve(left.transpose());
  const Eigen::Vector2d inverse_squares =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(relative, Eigen::EigenvaluesOnly).eigenvalues();
  const double longest = 1 / std::sqrt(inverse_squares[0]), shortest = 1 / std::sqrt(inverse_squares[1]);
  const double slack = 1.5 * usual.relative_sigma + 2 / significance;
  if (shortest > kWider + slack || longest < kNarrower / (1 + slack)) return SpotFate::kStreak;
  if (longest > kWider + slack) return SpotFate::kDoubled;
  return SpotFate::kGood;
}

void mark_doubles(std::vector<SpotCandidate>& candidates, double sigma_px) {
  const double apart = kDoubleSigmas * sigma_px;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    for (std::size_t k = i + 1; k < candidates.size(); ++k) {
      SpotCandidate &a = candidates[i], &b = candidates[k];
      if (b.peak.y() - a.peak.y() > apart + 4) break;
      if ((a.fit.spot.pixel - b.fit.spot.pixel).norm() > apart) continue;
      const auto counts = [](const SpotCandidate& spot) {
        return spot.fate == SpotFate::kGood || spot.fate == SpotFate::kDoubled || spot.fate == SpotFate::kSaturated;
      };
      if (!counts(a) || !counts(b)) continue;
      if (a.fate == SpotFate::kGood) a.fate = SpotFate::kDoubled;
      if (b.fate == SpotFate::kGood) b.fate = SpotFate::kDoubled;
    }
  }
}

}  // namespace raybundle
