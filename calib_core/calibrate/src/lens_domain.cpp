// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/calibrate/lens_domain.hpp"

#include <algorithm>
#include <cmath>

#include "raybundle/bundle/parameters.hpp"
#include "raybundle/initialize/other_optima.hpp"
#include "robust_solve.hpp"

namespace raybundle {
namespace {

constexpr double kBeyond = 1.05;         // times the farthest corner's angle: corners seldom come closer to the border
constexpr double kPlainlyWorse = 1.2;    // times the noise under the lens that ends among its corners
constexpr double kExact = 1e-3;          // of a corner's sigma: less noise than that is rounding
constexpr int kFirstShapeParameter = 4;  // after fx, fy, cx and cy

// Calls visit(point in the camera, view, index) for each corner of a camera's views in use.
template <typename Visitor>
void for_each_corner(const CalibrationProblem& problem, const BundleState& state, int camera, const Visitor& visit) {
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    const TargetView& view = problem.views[v];
    if (view.camera != camera || state.pose_of_view[v] < 0) continue;
    const Rigid3 pose = camera_from_target(problem, state, v);
    const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
    for (std::size_t i = 0; i < view.observations.size(); ++i) {
      const TargetPoint& point = *problem.targets[view.target].find(view.observations[i].point_id);
      Eigen::Vector3d x = rotation * point.x_in_target;
      if (!point.infinitely_far) x += pose.translation;
      visit(x, v, i);
    }
  }
}

// Indices of the free coefficients of the radial profile, the last first.
std::vector<int> free_coefficients(const CalibrationProblem& single) {
  const std::vector<std::string_view> names = parameter_names(single.cameras[0].model);
  const ParameterBlock intrinsics = parameter_blocks(single).front();
  std::vector<int> coefficients;
  for (int k = static_cast<int>(names.size()) - 1; k >= kFirstShapeParameter; --k) {
    const bool free = intrinsics.parameters[k].kind == ParameterRule::Kind::kFree;
    if (free && names[k].front() == 'k') coefficients.push_back(k);
  }
  return coefficients;
}

/// A problem whose lens has lost some coefficients, and its optimum.
struct Simpler {
  CalibrationProblem problem;
  BundleState state;
  BundleSummary summary;

  bool reaches_beyond_corners() const {
    return summary.termination == Termination::kConverged && !ends_among_corners(problem, state, 0);
  }
};

}  // namespace

bool ends_among_corners(const CalibrationProblem& problem, const BundleState& state, int camera) {
  double cosine = 1.0;  // of the farthest corner's angle off the axis
  for_each_corner(problem, state, camera, [&](const Eigen::Vector3d& x, int v, std::size_t i) {
    if (state.fates[v][i] == ObservationFate::kUsed) cosine = std::min(cosine, x.z() / x.norm());
  });
  const double farthest_rad = std::acos(cosine);
  const double wanted_rad = kBeyond * farthest_rad;
  // A rectilinear lens that has no end reaches just 90 degrees.
  return max_angle_rad(state.cameras[camera]) < (farthest_rad < M_PI_2 ? std::min(wanted_rad, M_PI_2) : wanted_rad);
}

bool spoils_lens(const CalibrationProblem& single, const BundleState& before, const BundleState& after) {
  return ends_among_corners(single, after, 0) && !ends_among_corners(single, before, 0);
}

bool give_up_coefficients(CalibrationProblem& single, BundleState& state, BundleSummary& summary,
                          const SolveFunction& solve) {
  if (!ends_among_corners(single, state, 0)) return false;
  std::vector<Eigen::Vector3d> rays;  // of corners that are not known to be wrong
  std::vector<Eigen::Vector2d> pixels;
  for_each_corner(single, state, 0, [&](const Eigen::Vector3d& x, int v, std::size_t i) {
    if (state.fates[v][i] == ObservationFate::kOutlier) return;
    rays.push_back(x.normalized());
    pixels.push_back(single.views[v].observations[i].pixel);
  });
  const std::string prefix = single.cameras[0].name + ".";
  const std::vector<std::string_view> names = parameter_names(single.cameras[0].model);
  const std::vector<int> coefficients = free_coefficients(single);
  Simpler simpler{single, {}, {}};
  std::vector<int> zeros;
  for (std::size_t count = 0; count <= coefficients.size() && !simpler.reaches_beyond_corners(); ++count) {
    if (count > 0) {
      zeros.push_back(coefficients[count - 1]);
      const std::string name = prefix + std::string(names[zeros.back()]);
      simpler.problem.rules.push_back({name, ParameterRule::Kind::kFixed, 0.0, 0.0});
    }
    simpler.state = state;
    simpler.state.cameras[0] = fitted_anew(state.cameras[0], rays, pixels, zeros);
    mark_projectable(simpler.problem, simpler.state);
    simpler.summary = solve(simpler.problem, simpler.state);
  }
  if (!simpler.reaches_beyond_corners()) return false;
  const double noise = std::max(robust_sigmas(single, state)[0], kExact);
  if (!(robust_sigmas(simpler.problem, simpler.state)[0] <= kPlainlyWorse * noise)) return false;
  for (Simpler fuller = simpler; fuller.problem.rules.size() > single.rules.size(); simpler = fuller) {
    fuller.problem.rules.pop_back();
    fuller.summary = solve(fuller.problem, fuller.state);
    if (!fuller.reaches_beyond_corners()) break;
  }
  single = std::move(simpler.problem);
  state = std::move(simpler.state);
  summary = simpler.summary;
  return true;
}

}  // namespace raybundle
