// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "splined_opinion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "projection_difference.hpp"

namespace raybundle {
namespace {

constexpr const char* kStereographic = "LENSMODEL_STEREOGRAPHIC";
constexpr double kFieldMargin = 1.05;  // of the spline over the corners, so that none leaves it while it is solved for
constexpr int kFewestCells = 8, kMostCells = 27;  // along the longer side; mrcal's studies use up to 30 knots
constexpr int kFewestCorners = 8;                 // around a place where a spline is believed
constexpr int kOuterKnots = 3;                    // of a cubic spline, beyond one for each cell

// How mrcal's splines are laid out: by u, the stereographic image of a ray, with |u| = 2 tan(angle / 2).
struct SplineLayout {
  int columns = 0;  // of knots
  int rows = 0;
  int field_deg = 0;  // along x

  double spacing() const { return 4.0 * std::tan(field_deg * M_PI / 720.0) / (columns - kOuterKnots); }

  std::string name() const {
    return fmt::format("LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx={}_Ny={}_fov_x_deg={}", columns, rows, field_deg);
  }
};

Eigen::Vector2d stereographic(const Eigen::Vector3d& ray) { return 2.0 * ray.head<2>() / (ray.norm() + ray.z()); }

// Where a spline is held by corners, and not only by what it is continued to.
class Support {
 public:
  Support(const MrcalProblem& request, const RigCamera& camera, int index, double spacing) : reach_(1.5 * spacing) {
    for (const MrcalView& view : request.views) {
      if (view.camera != index) continue;
      for (const MrcalCorner& corner : view.corners) {
        if (const auto ray = ray_from_pixel(camera.camera, corner.pixel)) corners_.push_back(stereographic(*ray));
      }
    }
  }

  // Whether there are corners within one and a half knots of a ray, on all four sides.
  bool surrounds(const Eigen::Vector3d& ray) const {
    const Eigen::Vector2d at = stereographic(ray);
    int corners = 0;
    std::array<bool, 4> sides{};
    for (const Eigen::Vector2d& corner : corners_) {
      const Eigen::Vector2d off = corner - at;
      if (off.cwiseAbs().maxCoeff() > reach_) continue;
      ++corners;
      sides[(off.x() > 0.0 ? 1 : 0) + (off.y() > 0.0 ? 2 : 0)] = true;
    }
    return corners >= kFewestCorners && std::ranges::all_of(sides, std::identity());
  }

 private:
  double reach_;
  std::vector<Eigen::Vector2d> corners_;
};

SplineLayout layout_for(const MrcalProblem& request, const Calibration& first) {
  Eigen::Vector2d reach(0.0, 0.0);
  std::vector<int> corners(first.cameras.size(), 0);
  for (const MrcalView& view : request.views) {
    for (const MrcalCorner& corner : view.corners) {
      const auto ray = ray_from_pixel(first.cameras[view.camera].camera, corner.pixel);
      if (ray) reach = reach.cwiseMax(stereographic(*ray).cwiseAbs());
    }
    corners[view.camera] += static_cast<int>(view.corners.size());
  }
  SplineLayout layout;
  layout.field_deg = static_cast<int>(std::ceil(4.0 * std::atan(0.5 * kFieldMargin * reach.x()) * 180.0 / M_PI));
  const double half_field = 2.0 * std::tan(layout.field_deg * M_PI / 720.0);
  const double aspect = kFieldMargin * reach.y() / half_field;
  const double cells = *std::ranges::min_element(corners) / kCornersPerCell;
  const double along =
      std::clamp(std::sqrt(cells * std::max(aspect, 1.0 / aspect)), 1.0 * kFewestCells, 1.0 * kMostCells);
  const int across_x = std::max(1, static_cast<int>(std::lround(aspect > 1.0 ? along / aspect : along)));
  layout.columns = across_x + kOuterKnots;
  layout.rows = static_cast<int>(std::ceil(across_x * aspect)) + kOuterKnots;
  return layout;
}

// Stereographic lenses that fit the centre of the image, where all lenses are alike.
void start_stereographic(MrcalProblem& request, const Calibration& first) {
  request.lens_model = kStereographic;
  for (std::size_t c = 0; c < request.cameras.size(); ++c) {
    request.cameras[c].parameters = first.cameras[c].camera.parameters.head<4>();
  }
}

void start_splined(MrcalProblem& request, const MrcalAnswer& stereographic, const std::string& model) {
  request.lens_model = model;
  request.cameras = stereographic.cameras;
  request.rig_from_target = stereographic.rig_from_target;
  for (MrcalCamera& camera : request.cameras) {
    const Eigen::Vector4d core = camera.parameters;
    camera.parameters.setZero(mrcal_parameter_count(model));
    camera.parameters.head<4>() = core;
  }
}

// Lenses of a first solve with stereographic ones, then with splines.
std::optional<std::vector<MrcalCamera>> splined_lenses(MrcalProblem request, const Calibration& first,
                                                       const SplineLayout& layout, double& rms_px) {
  start_stereographic(request, first);
  const std::optional<MrcalAnswer> stereographic = solve_with_mrcal(request);
  if (!stereographic) return std::nullopt;
  start_splined(request, *stereographic, layout.name());
  const std::optional<MrcalAnswer> splined = solve_with_mrcal(request);
  if (!splined) return std::nullopt;
  rms_px = splined->rms_px;
  return splined->cameras;
}

// The same corners exactly where the first opinion projects them.
MrcalProblem predicted(MrcalProblem request) {
  for (MrcalView& view : request.views) {
    for (MrcalCorner& corner : view.corners) corner.pixel = corner.predicted;
  }
  return request;
}

}  // namespace

SecondOpinion splined_opinion(const MrcalProblem& request, const Calibration& first) {
  const SplineLayout layout = layout_for(request, first);
  SecondOpinion opinion;
  opinion.source = "mrcal, " + layout.name();
  double exact_rms_px = 0.0;
  const auto lenses = splined_lenses(request, first, layout, opinion.rms_px);
  const auto exact = splined_lenses(predicted(request), first, layout, exact_rms_px);
  if (!lenses || !exact) {
    opinion.why_not = "mrcal's optimiser did not find a solution";
    return opinion;
  }
  const std::string model = layout.name();
  opinion.comparison.emplace();
  double most_px = 0.0;
  for (std::size_t c = 0; c < first.cameras.size(); ++c) {
    const Support support(request, first.cameras[c], static_cast<int>(c), layout.spacing());
    const auto difference_of = [&](const MrcalCamera& solved) {
      const Lens lens = [&](const Eigen::Vector3d& ray) -> std::optional<SeenRay> {
        if (!support.surrounds(ray)) return std::nullopt;
        return mrcal_pixel(model, solved.parameters, ray);
      };
      return projection_difference(first.cameras[c], first.covariance, lens, ComparisonOptions{}.columns);
    };
    const ProjectionDifference method = difference_of((*exact)[c]);
    const ProjectionDifference difference = less(difference_of((*lenses)[c]), method);
    if (difference.covered_share == 0.0) {
      opinion.comparison.reset();
      opinion.why_not =
          "mrcal's splines see nothing of what the corners of camera " + first.cameras[c].name + " surround";
      return opinion;
    }
    opinion.comparison->projections.push_back(difference);
    most_px = std::max(most_px, method.rms_px);
  }
  opinion.approximation_px = most_px;
  opinion.remark = fmt::format(
      "{} x {} knots instead of a formula; of corners exactly where our lens projects them they make a lens that is "
      "{:.3f} px rms off, which is taken out here; the sigmas are ours, and knots are noisier",
      layout.columns, layout.rows, most_px);
  return opinion;
}

}  // namespace raybundle
