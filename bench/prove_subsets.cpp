// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Any eight views are enough: on every set of real images and with every sensible model, random subsets of the frames
// must give the camera that all frames give, or be refused with a reason. The same camera means: over the corners of
// all frames that lie where the subset saw corners too, the projections differ, root mean square and the implied turn
// removed, by at most 3 sigmas of the difference, whose variance is the sum of both (the subset's is much the larger).
// Sigmas are those that the program goes by: of the corners' noise or of how the frames scatter, whichever is worse. A
// model is sensible for a set when it fits all frames to within a quarter of the best model's residuals.
// usage: prove_subsets [subsets of each set and model] [set] [model]
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>

#include "projection.hpp"
#include "random_rig.hpp"
#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/geometry/error.hpp"
#include "real_sets.hpp"

namespace {

using namespace raybundle;
using namespace raybundle::bench;
using namespace raybundle::testing;

constexpr std::size_t kFewestFrames = 8;
constexpr double kSensible = 1.25;  // times the best model's rms
constexpr double kSigmas = 3.0;

struct Solved {
  CalibrationResult result;
  std::vector<std::vector<Eigen::Vector3d>> rays;  // of each camera: those of the corners in use
};

CalibrationProblem with_model_of(CalibrationProblem problem, std::string_view model) {
  for (ProblemCamera& camera : problem.cameras) camera.model = *model_named(model);
  return problem;
}

CalibrationProblem with_frames(const CalibrationProblem& whole, const std::vector<int>& frames) {
  CalibrationProblem part = whole;
  std::erase_if(part.views, [&](const TargetView& view) { return !std::ranges::binary_search(frames, view.frame); });
  return part;
}

// One thread: so small a problem gains little from more.
CalibrationResult calibrate_alone(const CalibrationProblem& problem) { return calibrate(problem, {.threads = 1}); }

Solved solve(const CalibrationProblem& problem) {
  Solved solved{calibrate_alone(problem), std::vector<std::vector<Eigen::Vector3d>>(problem.cameras.size())};
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    const ViewResult& view = solved.result.views[v];
    if (view.pose < 0) continue;
    const int camera = problem.views[v].camera;
    const Rigid3 camera_from_target =
        camera_named(solved.result.calibration, problem.cameras[camera].name).camera_from_rig *
        solved.result.poses[view.pose].rig_from_target;
    for (std::size_t i = 0; i < view.fates.size(); ++i) {
      if (view.fates[i] != ObservationFate::kUsed) continue;
      const Observation& observation = problem.views[v].observations[i];
      const TargetPoint* point = problem.targets[problem.views[v].target].find(observation.point_id);
      solved.rays[camera].push_back((camera_from_target * point->x_in_target).normalized());
    }
  }
  return solved;
}

double sigma_px(const Calibration& calibration, const RigCamera& camera, const std::vector<Eigen::Vector3d>& rays) {
  const double sigma = projection_sigma_px(
      camera.camera, covariance_of_intrinsics(calibration.covariance, camera.name, camera.camera.model), rays);
  if (!calibration.covariance_by_frame) return sigma;
  const Eigen::MatrixXd by_frame =
      covariance_of_intrinsics(*calibration.covariance_by_frame, camera.name, camera.camera.model);
  return std::max(sigma, projection_sigma_px(camera.camera, by_frame, rays));
}

// The rays of a solve's camera that lie where another calibration of it claims anything: in cells of the image where it
// saw corners, and short of where its lens ends.
std::vector<Eigen::Vector3d> rays_claimed(const RigCamera& reference, const std::vector<Eigen::Vector3d>& rays,
                                          const RigCamera& camera) {
  std::vector<Eigen::Vector3d> claimed;
  for (const Eigen::Vector3d& ray : rays) {
    const auto pixel = pixel_from_ray(reference.camera, ray);
    if (!pixel || !camera.evidence->covers(camera.camera.size, *pixel)) continue;
    if (ray_from_pixel(camera.camera, *pixel)) claimed.push_back(ray);
  }
  return claimed;
}

/// How far a subset's cameras are from those of all frames.
struct Difference {
  double sigmas = 0.0;  // of the difference, of the camera that differs most
  double share = 1.0;   // of the rays of all frames' corners that are compared, of the camera with the fewest
};

Difference difference(const CalibrationProblem& problem, const Solved& all, const CalibrationResult& part) {
  Difference worst;
  for (const RigCamera& camera : part.calibration.cameras) {
    const auto c = std::ranges::find(problem.cameras, camera.name, &ProblemCamera::name) - problem.cameras.begin();
    const RigCamera& reference = camera_named(all.result.calibration, camera.name);
    const std::vector<Eigen::Vector3d> rays = rays_claimed(reference, all.rays[c], camera);
    if (rays.empty()) return {INFINITY, 0.0};  // nothing that both claim
    const double sigma =
        std::hypot(sigma_px(all.result.calibration, reference, rays), sigma_px(part.calibration, camera, rays));
    const double sigmas = projection_difference_px(reference.camera, camera.camera, rays) / sigma;
    if (!(sigmas <= worst.sigmas)) worst.sigmas = std::isnan(sigmas) ? INFINITY : sigmas;
    worst.share = std::min(worst.share, static_cast<double>(rays.size()) / static_cast<double>(all.rays[c].size()));
  }
  return worst;
}

std::vector<int> random_frames(const std::vector<int>& frames, Draw& draw) {
  std::vector<int> chosen = frames;
  for (std::size_t i = chosen.size() - 1; i > 0; --i) {
    std::swap(chosen[i], chosen[static_cast<std::size_t>(draw.integer(0, static_cast<int>(i)))]);
  }
  chosen.resize(static_cast<std::size_t>(draw.integer(kFewestFrames, static_cast<int>(frames.size()) - 1)));
  std::ranges::sort(chosen);
  return chosen;
}

struct Tally {
  int same = 0, refused = 0, outside = 0;
  double worst_sigmas = 0.0;
  double least_share = 1.0;  // Difference::share
};

Tally prove(const std::string& name, const CalibrationProblem& problem, const Solved& all, int subsets) {
  std::vector<int> frames;
  for (const TargetView& view : problem.views) frames.push_back(view.frame);
  std::ranges::sort(frames);
  frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
  Tally tally;
  for (int seed = 0; seed < subsets; ++seed) {
    Draw draw(static_cast<std::uint64_t>(seed));
    const std::vector<int> chosen = random_frames(frames, draw);
    try {
      const auto [sigmas, share] = difference(problem, all, calibrate_alone(with_frames(problem, chosen)));
      tally.worst_sigmas = std::max(tally.worst_sigmas, sigmas);
      tally.least_share = std::min(tally.least_share, share);
      if (sigmas <= kSigmas) {
        ++tally.same;
        continue;
      }
      ++tally.outside;
      fmt::print("  {}, subset {} of {} frames: off by {:.1f} sigmas\n", name, seed, chosen.size(), sigmas);
    } catch (const Error& error) {
      ++tally.refused;
      fmt::print("  {}, subset {} of {} frames: {}\n", name, seed, chosen.size(), error.what());
    }
  }
  return tally;
}

// The models that fit a set, with their full solves.
std::map<std::string, Solved> sensible_models(const CalibrationProblem& problem) {
  std::map<std::string, Solved> solved;
  double best = std::numeric_limits<double>::infinity();
  for (const std::string_view model : model_names()) {
    try {
      Solved all = solve(with_model_of(problem, model));
      if (all.result.calibration.cameras.size() < problem.cameras.size()) continue;
      best = std::min(best, all.result.rms_px);
      solved.emplace(model, std::move(all));
    } catch (const Error& error) {
      fmt::print("  {} cannot take all frames: {}\n", model, error.what());
    }
  }
  std::erase_if(solved, [&](const auto& entry) { return entry.second.result.rms_px > kSensible * best; });
  return solved;
}

}  // namespace

int main(int argc, char** argv) {
  const int subsets = argc > 1 ? std::max(1, std::atoi(argv[1])) : 20;
  const std::string only_set = argc > 2 ? argv[2] : "", only_model = argc > 3 ? argv[3] : "";
  const std::filesystem::path program = std::filesystem::path(argv[0]).parent_path() / "raybundle";
  std::string table;
  int outside = 0;
  for (const RealSet& set : real_sets()) {
    if (!only_set.empty() && only_set != set.name) continue;
    const std::optional<CalibrationProblem> observed = observations_of(set, program);
    if (!observed) continue;
    for (const auto& [model, all] : sensible_models(*observed)) {
      if (!only_model.empty() && only_model != model) continue;
      const CalibrationProblem problem = with_model_of(*observed, model);
      const Tally tally = prove(set.name + " " + model, problem, all, subsets);
      table += fmt::format("{:<22} {:<18} {:>6.3f} {:>5} {:>8} {:>8} {:>7.1f} {:>8.0f} %\n", set.name, model,
                           all.result.rms_px, tally.same, tally.refused, tally.outside, tally.worst_sigmas,
                           100 * tally.least_share);
      outside += tally.outside;
    }
  }
  if (table.empty()) {
    fmt::print("there are no real images here: RAYBUNDLE_DATA names their folder\n");
    return 1;
  }
  fmt::print("{:<22} {:<18} {:>6} {:>5} {:>8} {:>8} {:>7} {:>10}\n{}", "set", "model", "rms px", "same", "refused",
             "outside", "sigmas", "compared", table);
  fmt::print("{} subsets outside of {:g} sigmas; the bar is 0\n", outside, kSigmas);
  return outside == 0 ? 0 : 1;
}
