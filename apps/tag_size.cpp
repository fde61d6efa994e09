// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "tag_size.hpp"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <vector>

#include "raybundle/geometry/quantile.hpp"

namespace raybundle::apps {
namespace {

constexpr int kFewestCorners = 8;        // of a view that has a say
constexpr std::size_t kFewestViews = 3;  // whose scatter tells how well they agree
constexpr double kSurely_sigma = 4.0;
constexpr double kSmallestGain = 0.2;  // of the residuals' squares

// Residuals of a view against how the pixels move where each tag grows about its middle, in sums of squares [px²].
struct Growth {
  double moved = 0.0, along = 0.0, residual = 0.0;
  int corners = 0;

  double least_squares() const { return along / moved; }
  double gain(double growth) const { return growth * (2.0 * along - growth * moved); }
};

Eigen::Vector3d middle_of_tag(const Target& target, int tag) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int corner = 0; corner < 4; ++corner) sum += target.find(4 * tag + corner)->x_in_target;
  return sum / 4.0;
}

// The derivative of a corner's pixel by the size of its tag, in parts of that size.
std::optional<Eigen::Vector2d> pixel_by_growth(const Camera& camera, const Rigid3& camera_from_target,
                                               const Eigen::Vector3d& corner, const Eigen::Vector3d& middle) {
  constexpr double kStep = 0.01;
  const auto smaller = pixel_from_ray(camera, camera_from_target * (corner - kStep * (corner - middle)));
  const auto larger = pixel_from_ray(camera, camera_from_target * (corner + kStep * (corner - middle)));
  if (!smaller || !larger) return std::nullopt;
  return (*larger - *smaller) / (2.0 * kStep);
}

Growth growth_of(const CalibrationProblem& problem, const CalibrationResult& result, std::size_t v) {
  const TargetView& view = problem.views[v];
  const ViewResult& fit = result.views[v];
  const Target& target = problem.targets[view.target];
  const RigCamera& camera = camera_named(result.calibration, problem.cameras[view.camera].name);
  const Rigid3 camera_from_target = camera.camera_from_rig * result.poses[fit.pose].rig_from_target;
  Growth growth;
  for (std::size_t i = 0; i < view.observations.size(); ++i) {
    if (fit.fates[i] != ObservationFate::kUsed) continue;
    const int id = view.observations[i].point_id;
    const auto moved =
        pixel_by_growth(camera.camera, camera_from_target, target.find(id)->x_in_target, middle_of_tag(target, id / 4));
    if (!moved) continue;
    growth.moved += moved->squaredNorm();
    growth.along += moved->dot(fit.residuals_px[i]);
    growth.residual += fit.residuals_px[i].squaredNorm();
    ++growth.corners;
  }
  return growth;
}

}  // namespace

std::string tag_size_warning(const AprilGrid& grid, int target, const CalibrationProblem& problem,
                             const CalibrationResult& result) {
  std::vector<Growth> of_views;
  std::vector<double> estimates;
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    if (problem.views[v].target != target || result.views[v].pose < 0) continue;
    const Growth growth = growth_of(problem, result, v);
    if (growth.corners < kFewestCorners) continue;
    of_views.push_back(growth);
    estimates.push_back(growth.least_squares());
  }
  if (of_views.size() < kFewestViews) return {};
  const double growth = median(estimates);
  std::vector<double> deviations;
  double residual = 0.0, gain = 0.0;
  int corners = 0;
  for (const Growth& view : of_views) {
    deviations.push_back(std::abs(view.least_squares() - growth));
    residual += view.residual;
    gain += view.gain(growth);
    corners += view.corners;
  }
  // Of normal values: sigma over their median deviation, times the median's sigma over the mean's.
  constexpr double kSigmaOfMedian = 1.4826 * 1.2533;
  const double sigma = kSigmaOfMedian * median(deviations) / std::sqrt(static_cast<double>(of_views.size()));
  if (std::abs(growth) < kSurely_sigma * sigma || gain < kSmallestGain * residual) return {};
  const double tag_m = grid.tag_m * (1.0 + growth);
  const double spacing = grid.tag_m * (1.0 + grid.spacing) / tag_m - 1.0;
  return fmt::format(
      "the tags of {} look {:.1f} % {} than stated, against the distance from tag to tag: with a spacing of about {:.3f} "
      "instead of {:.4g} (tags of {:.4g} mm instead of {:.4g}, if that distance is right) the corners would lie {:.2f} px off "
      "instead of {:.2f}; measure the edge of a tag and the gap again{}",
      problem.targets[target].name, 100.0 * std::abs(growth), growth < 0 ? "smaller" : "larger", spacing, grid.spacing,
      1e3 * tag_m, 1e3 * grid.tag_m, std::sqrt((residual - gain) / corners), std::sqrt(residual / corners),
      growth < 0 ? ", and expose less: white paper that glares eats into the black" : "");
}

}  // namespace raybundle::apps
