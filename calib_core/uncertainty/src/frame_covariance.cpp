// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/frame_covariance.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "raybundle/geometry/threads.hpp"

namespace raybundle {
namespace {

constexpr double kOneFrameAlone = 0.99;  // share of what is known of a direction, from one frame

// The nearest symmetric matrix without negative directions: pairs of frames that are alike make none that could be
// trusted.
Eigen::MatrixXd positive_part(const Eigen::MatrixXd& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(symmetric);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() * eigen.eigenvectors().transpose();
}

}  // namespace

std::optional<Covariance> covariance_by_frame(const ReducedInformation& all,
                                              const std::vector<FrameInformation>& frames,
                                              const std::optional<Eigen::MatrixXd>& repeated, int threads) {
  const int freedom = all.residuals - all.parameters;
  if (static_cast<int>(frames.size()) < kFewestFrames || freedom <= 0) return std::nullopt;
  const Eigen::Index size = all.information.rows();
  if (size == 0) return std::nullopt;
  const Eigen::VectorXd scale = all.information.diagonal().cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return std::nullopt;
  const Eigen::LLT<Eigen::MatrixXd> factor(scale.asDiagonal() * all.information * scale.asDiagonal());
  if (factor.info() != Eigen::Success) return std::nullopt;
  const auto lower = factor.matrixL();

  // In coordinates in which the whole information is one, a frame's share b of a direction tells how much of the
  // frame's own error its residuals still show: 1 - b. The middle of the sandwich is the sum of the mended gradients'
  // squares.
  const auto in_coordinates = [&](const Eigen::MatrixXd& symmetric) {
    Eigen::MatrixXd result = scale.asDiagonal() * symmetric * scale.asDiagonal();
    lower.solveInPlace(result);
    result.transposeInPlace();
    lower.solveInPlace(result);
    return result;
  };
  const double variance_factor = all.chi2 / freedom;
  Eigen::MatrixXd plain = Eigen::MatrixXd::Identity(size, size);  // what is not told by frames
  Eigen::MatrixXd middle = Eigen::MatrixXd::Zero(size, size);
  std::vector<Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>> axes_of(frames.size());
  for_each_index(frames.size(), threads,
                 [&](std::size_t f) { axes_of[f].compute(in_coordinates(frames[f].information)); });
  for (std::size_t f = 0; f < frames.size(); ++f) {
    Eigen::VectorXd gradient = scale.asDiagonal() * frames[f].gradient;
    lower.solveInPlace(gradient);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>& axes = axes_of[f];
    Eigen::VectorXd along = axes.eigenvectors().transpose() * gradient;
    for (Eigen::Index k = 0; k < size; ++k) {
      const double b = axes.eigenvalues()[k];
      if (b > kOneFrameAlone) {
        along[k] = 0.0;
        continue;
      }
      along[k] /= std::sqrt(1.0 - b);
      plain -= b * axes.eigenvectors().col(k) * axes.eigenvectors().col(k).transpose();
    }
    const Eigen::VectorXd mended = axes.eigenvectors() * along;
    middle += mended * mended.transpose();
  }
  middle += variance_factor * plain;
  if (repeated) middle += variance_factor * positive_part(in_coordinates(*repeated));

  // L⁻ᵀ middle L⁻¹ as the square of a half, so that rounding leaves no negative variance; then out of the scaled columns.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(middle);
  Eigen::MatrixXd half = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  lower.transpose().solveInPlace(half);
  half = scale.asDiagonal() * half;
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(size, size);
  matrix.selfadjointView<Eigen::Lower>().rankUpdate(half);
  return Covariance{all.names, matrix.selfadjointView<Eigen::Lower>()};
}

std::vector<FrameScatter> frame_scatter(const Covariance& plain, const Covariance& by_frame) {
  std::vector<FrameScatter> scatter;
  for (std::size_t i = 0; i < plain.names.size(); ++i) {
    const double sigma = plain.sigma(plain.names[i]);
    if (sigma > 0.0) scatter.push_back({plain.names[i], by_frame.sigma(plain.names[i]) / sigma});
  }
  std::ranges::stable_sort(scatter, std::ranges::greater{}, &FrameScatter::ratio);
  return scatter;
}

double larger_sigma(const Calibration& calibration, const std::function<double(const Covariance&)>& sigma_by) {
  const double sigma = sigma_by(calibration.covariance);
  return calibration.covariance_by_frame ? std::max(sigma, sigma_by(*calibration.covariance_by_frame)) : sigma;
}

double material_ratio(int frames) { return std::max(1.3, 1.0 + 3.0 / std::sqrt(2.0 * frames)); }

std::optional<std::string> frame_scatter_warning(const Covariance& plain, const Covariance& by_frame, int frames) {
  const std::vector<FrameScatter> scatter = frame_scatter(plain, by_frame);
  if (scatter.empty() || scatter.front().ratio <= material_ratio(frames)) return std::nullopt;
  std::string worst;
  constexpr std::size_t kNamed = 3;
  for (std::size_t i = 0; i < std::min(kNamed, scatter.size()); ++i) {
    if (scatter[i].ratio <= material_ratio(frames)) break;
    worst += fmt::format("{}{} {:.1f} times", worst.empty() ? "" : ", ", scatter[i].name, scatter[i].ratio);
  }
  const double typical = scatter[scatter.size() / 2].ratio;
  return fmt::format(
      "the corners of a frame err together: the frames disagree by more than the sigmas say ({}; the middle parameter "
      "{:.1f} times), as with a lens model that does not fit, a board that is not flat, or blur; trust "
      "covariance_by_frame rather than covariance",
      worst, typical);
}

}  // namespace raybundle
