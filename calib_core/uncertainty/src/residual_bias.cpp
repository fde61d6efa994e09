// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/residual_bias.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "raybundle/uncertainty/image_cells.hpp"
#include "raybundle/uncertainty/projection_uncertainty.hpp"

namespace raybundle {
namespace {

constexpr int kColumns = 8;                // parts along the image's width
constexpr double kBand_rad = M_PI / 18.0;  // 10 degrees
constexpr int kFewestInSum = 4;  // views of a part: a sum over parts does not need each scatter to be well known
constexpr double kBeyondDoubtSigmas = 5.0;  // some fifty parts of a few views each: chance rarely reaches 4

// Sums of one view's residuals in a group.
struct ViewSum {
  int corners = 0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
};

// Residuals of a group, by view: corners of a view share the error of its pose.
struct Gathered {
  std::map<int, ViewSum> views;
  double squares = 0.0;

  void add(int view, const Eigen::Vector2d& residual) {
    ViewSum& sum = views[view];
    ++sum.corners;
    sum.sum += residual;
    squares += residual.squaredNorm();
  }

  ResidualGroup group() const {
    ResidualGroup group;
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const auto& [view, of_view] : views) {
      group.corners += of_view.corners;
      sum += of_view.sum;
    }
    group.views = static_cast<int>(views.size());
    if (group.corners == 0) return group;
    const double corners = group.corners;
    group.mean_px = sum / corners;
    group.rms_px = std::sqrt(squares / corners);
    if (group.views < 2) return group;
    Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
    for (const auto& [view, of_view] : views) {
      const Eigen::Vector2d off = of_view.sum - of_view.corners * group.mean_px;
      scatter += off * off.transpose();
    }
    scatter *= group.views / (group.views - 1.0) / (corners * corners);
    group.mean_sigma_px = largest_sigma(scatter);
    return group;
  }
};

// Along the direction away from the axis, and across it.
Eigen::Vector2d radial_and_tangential(const Camera& lens, const Eigen::Vector2d& pixel,
                                      const Eigen::Vector2d& residual) {
  const Eigen::Vector2d outwards = (pixel - Eigen::Vector2d(lens.cx(), lens.cy())).normalized();
  return {outwards.dot(residual), outwards.x() * residual.y() - outwards.y() * residual.x()};
}

void summarize(ResidualBias& bias) {
  double corners = 0.0, squares = 0.0, systematic = 0.0;
  for (std::size_t i = 0; i < bias.parts.size(); ++i) {
    const ResidualGroup& part = bias.parts[i];
    corners += part.corners;
    squares += part.corners * part.rms_px * part.rms_px;
    if (part.views < kFewestInSum) continue;
    // Chance gives the squared mean what the scatter of the views says, in each of two directions at most.
    systematic += part.corners * (part.mean_px.squaredNorm() - 2.0 * part.mean_sigma_px * part.mean_sigma_px);
    if (part.sigmas() > bias.strongest_sigmas) {
      bias.strongest_sigmas = part.sigmas();
      bias.strongest = static_cast<int>(i);
    }
  }
  if (corners == 0.0) return;
  bias.rms_px = std::sqrt(squares / corners);
  bias.bias_px = std::sqrt(std::max(0.0, systematic / corners));
  bias.noise_px = std::sqrt(std::max(0.0, (squares - std::max(0.0, systematic)) / corners));
}

}  // namespace

double ResidualGroup::sigmas() const {
  return views >= kFewestViews && mean_sigma_px > 0.0 ? mean_px.norm() / mean_sigma_px : 0.0;
}

double ResidualGroup::first_sigmas() const {
  return views >= kFewestViews && mean_sigma_px > 0.0 ? std::abs(mean_px.x()) / mean_sigma_px : 0.0;
}

int ResidualBias::strongest_band() const {
  const auto strongest = std::ranges::max_element(bands, {}, &ResidualGroup::first_sigmas);
  if (strongest == bands.end() || strongest->first_sigmas() == 0.0) return -1;
  return static_cast<int>(strongest - bands.begin());
}

bool ResidualBias::significant() const { return strongest_sigmas > kBeyondDoubtSigmas; }

ResidualBias residual_bias(const CalibrationProblem& problem, const CalibrationResult& result, int camera,
                           const Camera& lens) {
  ResidualBias bias;
  bias.size = lens.size;
  bias.columns = kColumns;
  bias.rows = rows_of_square_cells(lens.size, kColumns);
  bias.band_rad = kBand_rad;
  std::vector<Gathered> parts(static_cast<std::size_t>(bias.rows) * bias.columns);
  std::vector<Gathered> bands(static_cast<std::size_t>(std::ceil(M_PI / kBand_rad)));
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    const TargetView& view = problem.views[v];
    if (view.camera != camera || result.views[v].pose < 0) continue;
    for (std::size_t i = 0; i < view.observations.size(); ++i) {
      if (result.views[v].fates[i] != ObservationFate::kUsed) continue;
      const Eigen::Vector2d& pixel = view.observations[i].pixel;
      const Eigen::Vector2d& residual = result.views[v].residuals_px[i];
      const int column =
          std::clamp(static_cast<int>((pixel.x() + 0.5) * bias.columns / lens.size.width), 0, bias.columns - 1);
      const int row = std::clamp(static_cast<int>((pixel.y() + 0.5) * bias.rows / lens.size.height), 0, bias.rows - 1);
      parts[static_cast<std::size_t>(row) * bias.columns + column].add(v, residual);
      const std::optional<Eigen::Vector3d> ray = ray_from_pixel(lens, pixel);
      if (!ray) continue;
      const double angle = angle_off_axis(*ray);
      const auto band = std::min(static_cast<std::size_t>(angle / kBand_rad), bands.size() - 1);
      bands[band].add(v, radial_and_tangential(lens, pixel, residual));
    }
  }
  for (const Gathered& part : parts) bias.parts.push_back(part.group());
  for (const Gathered& band : bands) bias.bands.push_back(band.group());
  while (!bias.bands.empty() && bias.bands.back().corners == 0) bias.bands.pop_back();
  summarize(bias);
  return bias;
}

}  // namespace raybundle
