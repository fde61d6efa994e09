// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/calibrate/lens_domain.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "camera_corners.hpp"
#include "raybundle/bundle/parameters.hpp"
#include "raybundle/calibrate/lens_prior.hpp"
#include "raybundle/camera/plane_distortion.hpp"
#include "raybundle/initialize/other_optima.hpp"
#include "robust_solve.hpp"

namespace raybundle {
namespace {

// Times the farthest corner's angle: nearer to where a profile turns back the image is squeezed more than tenfold, and
// no detector finds a corner.
constexpr double kBeyond = 1.02;
// Times its radius in the plane: real profiles have no pole, and so near it bends them among the corners.
constexpr double kPoleBeyond = 1.22;
constexpr double kPlainlyWorse = 1.2;    // times the noise under the lens that ends among its corners
constexpr int kFirstShapeParameter = 4;  // after fx, fy, cx and cy

// Whether a model is a pinhole before a plane that is distorted by a profile with a denominator.
template <typename M>
concept HasDenominator = requires(const M& lens) {
  []<int n>(const DistortedPinhole<n>&) requires PlaneDistortion<n>::kHasDenominator {}
  (lens);
};

template <int n>
double pole_radius(const DistortedPinhole<n>&, const double* coefficients) {
  return PlaneDistortion<n>::pole_radius(coefficients);
}

// Radius in the plane at which a lens's profile has a pole.
double pole_radius(const Camera& lens) {
  return with_model(lens.model, [&]<CameraModel M>() {
    if constexpr (HasDenominator<M>) return pole_radius(M{}, lens.parameters.data() + kFirstShapeParameter);
    return std::numeric_limits<double>::infinity();
  });
}

// Indices of the coefficients of a camera's radial profile of which no rule says anything else, the last first.
std::vector<int> free_coefficients(const CalibrationProblem& problem, int camera) {
  const std::vector<std::string_view> names = parameter_names(problem.cameras[camera].model);
  std::vector<int> coefficients;
  for (const ParameterBlock& block : parameter_blocks(problem)) {
    if (block.kind != ParameterBlock::Kind::kIntrinsics || block.owner != camera) continue;
    for (int k = static_cast<int>(names.size()) - 1; k >= kFirstShapeParameter; --k) {
      const Parameter& parameter = block.parameters[k];
      const bool free = parameter.kind == ParameterRule::Kind::kFree || has_lens_prior(problem, parameter);
      if (free && names[k].front() == 'k') coefficients.push_back(k);
    }
  }
  return coefficients;
}

/// A problem of which a lens has lost some coefficients, and its optimum.
struct Simpler {
  CalibrationProblem problem;
  BundleState state;
  BundleSummary summary;

  bool reaches_beyond_corners(int camera) const {
    return summary.termination != Termination::kFailed && !ends_among_corners(problem, state, camera);
  }
};

// Root mean square of a camera's corners in use [sigmas].
double rms_sigmas(const CalibrationProblem& problem, const BundleState& state, int camera) {
  double squares = 0.0, corners = 0.0;
  const std::vector<std::vector<Eigen::Vector2d>> residuals = all_residuals(problem, state);
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    if (problem.views[v].camera != camera) continue;
    for (std::size_t i = 0; i < residuals[v].size(); ++i) {
      if (state.fates[v][i] != ObservationFate::kUsed) continue;
      squares += residuals[v][i].squaredNorm() / std::pow(problem.views[v].observations[i].sigma_px, 2);
      corners += 1.0;
    }
  }
  return std::sqrt(squares / std::max(corners, 1.0));
}

// Whether the simpler lens fits plainly worse. Of the same corners their sum tells it, more surely than the median does
// of few.
bool plainly_worse(const CalibrationProblem& problem, const BundleState& state, int camera, const Simpler& simpler) {
  const bool same_corners = simpler.state.fates == state.fates;
  const auto noise = [&](const CalibrationProblem& of, const BundleState& at) {
    return same_corners ? rms_sigmas(of, at, camera) : robust_sigmas(of, at)[camera];
  };
  const double before = std::max(noise(problem, state), kExactNoise);
  return !(noise(simpler.problem, simpler.state) <= kPlainlyWorse * before);
}

// Fits the lens anew with ever more of the coefficients at zero, from the state's poses; whether one of the fits
// reaches beyond the corners and is not plainly worse.
bool give_up_until_beyond(const CalibrationProblem& problem, const BundleState& state, int camera,
                          const std::vector<int>& coefficients, const SolveFunction& solve, Simpler& simpler) {
  simpler.problem = problem;
  const CameraCorners corners = right_corners(simpler.problem, state, camera);
  const Camera& lens = state.cameras[camera];
  const std::vector<std::string_view> names = parameter_names(lens.model);
  std::vector<int> zeros;  // with those that were given up before
  for (int k = kFirstShapeParameter; k < static_cast<int>(names.size()); ++k) {
    if (lens.parameters[k] == 0.0 && std::ranges::find(coefficients, k) == coefficients.end()) zeros.push_back(k);
  }
  for (std::size_t count = 0; count <= coefficients.size(); ++count) {
    if (count > 0) {
      zeros.push_back(coefficients[count - 1]);
      const std::string name = simpler.problem.cameras[camera].name + "." + std::string(names[zeros.back()]);
      simpler.problem.rules.push_back({name, ParameterRule::Kind::kFixed, 0.0, 0.0});
    }
    simpler.state = state;
    simpler.state.cameras[camera] = fitted_anew(lens, corners.rays, corners.pixels, zeros);
    mark_projectable(simpler.problem, simpler.state);
    simpler.summary = solve(simpler.problem, simpler.state);
    if (simpler.reaches_beyond_corners(camera) && !plainly_worse(problem, state, camera, simpler)) return true;
  }
  return false;
}

}  // namespace

bool can_have_pole(ModelId model) {
  return with_model(model, []<CameraModel M>() { return HasDenominator<M>; });
}

bool ends_among_corners(const CalibrationProblem& problem, const BundleState& state, int camera) {
  if (!can_have_pole(state.cameras[camera].model)) return false;
  const double farthest_rad = farthest_corner_rad(problem, state, camera);
  if (farthest_rad < M_PI_2 && pole_radius(state.cameras[camera]) < kPoleBeyond * std::tan(farthest_rad)) return true;
  const double wanted_rad = kBeyond * farthest_rad;
  // A rectilinear lens that has no end reaches just 90 degrees.
  return max_angle_rad(state.cameras[camera]) < (farthest_rad < M_PI_2 ? std::min(wanted_rad, M_PI_2) : wanted_rad);
}

bool spoils_lens(const CalibrationProblem& single, const BundleState& before, const BundleState& after) {
  return ends_among_corners(single, after, 0) && !ends_among_corners(single, before, 0);
}

bool give_up_coefficients(CalibrationProblem& problem, BundleState& state, int camera, BundleSummary& summary,
                          const SolveFunction& solve) {
  const std::vector<int> coefficients = free_coefficients(problem, camera);
  if (coefficients.empty() || !ends_among_corners(problem, state, camera)) return false;
  Simpler simpler;
  if (!give_up_until_beyond(problem, state, camera, coefficients, solve, simpler)) return false;
  for (Simpler fuller = simpler; fuller.problem.rules.size() > problem.rules.size(); simpler = fuller) {
    fuller.problem.rules.pop_back();
    fuller.summary = solve(fuller.problem, fuller.state);
    if (!fuller.reaches_beyond_corners(camera)) break;
  }
  problem = std::move(simpler.problem);
  state = std::move(simpler.state);
  summary = simpler.summary;
  return true;
}

}  // namespace raybundle
