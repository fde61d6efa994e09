// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Whether projections, and stereo depths, scatter as much as the uncertainty that is reported for them says: everywhere
// in the covered field, at 0.3 m, 1 m and infinity. One world each of a fisheye, a stereo head and a rig with a laser
// is observed again and again with other noise, each time solved for everything. What no image tells is taken out of
// each answer by its own means: the motion that aligns the corners, by Gauss-Newton with numeric derivatives. usage:
// prove_trust [seeds, default 800] [frames, default 25]
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <vector>

#include "aligned_projection.hpp"
#include "laser_world.hpp"
#include "raybundle/bundle/information.hpp"
#include "raybundle/uncertainty/corner_evidence.hpp"
#include "raybundle/uncertainty/covariance.hpp"
#include "raybundle/uncertainty/image_cells.hpp"
#include "raybundle/uncertainty/projection_uncertainty.hpp"
#include "raybundle/uncertainty/stereo_depth.hpp"
#include "true_state.hpp"

namespace {

using namespace raybundle;

constexpr double kSigma_px = 0.2;
constexpr double kLeastRatio = 0.9, kMostRatio = 1.1;
constexpr double kRanges_m[] = {0.3, 1.0, kInfinitelyFar};

struct World {
  testing::SyntheticWorld exact;
  BundleState truth;
};

World make_world(testing::SyntheticOptions options, bool with_laser) {
  options.seed = 11;
  World world{testing::synthetic_world(options), {}};
  testing::LaserTruth laser;
  if (with_laser) {
    laser = testing::add_laser(world.exact, {.grid = {.rows = 7, .columns = 7}, .noise_px = 0.0, .labelled = true});
  }
  for (TargetView& view : world.exact.problem.views) {
    for (Observation& observation : view.observations) observation.sigma_px = kSigma_px;
    for (Dot& dot : view.dots) dot.covariance_px2 = kSigma_px * kSigma_px * Eigen::Matrix2d::Identity();
  }
  world.truth = testing::true_state(world.exact);
  if (!with_laser) return world;
  constexpr int kLeastHits = 4;
  std::vector<int> hits(laser.lines.size(), 0);
  for (const TargetView& view : world.exact.problem.views) {
    for (const Dot& dot : view.dots) ++hits[dot.beam];
  }
  world.truth.beams = laser.lines;
  for (std::size_t b = 0; b < hits.size(); ++b) {
    if (hits[b] < kLeastHits) world.truth.beams[b].reset();
  }
  mark_dots(world.exact.problem, world.truth);
  return world;
}

// A pixel of a camera at a range, or a depth there, and its sums over the seeds.
struct Place {
  int camera = 0;
  Eigen::Vector2d pixel;
  double range_m = 0.0;
  Eigen::Matrix2d reported = Eigen::Matrix2d::Zero();  // of covariances
  Eigen::Matrix2d sampled = Eigen::Matrix2d::Zero();   // of squared errors
  double depth_reported = 0.0, depth_sampled = 0.0;    // of stereo depths [m²]

  // Reported over sampled sigma, in the direction in which the reported one is largest: chosen without the samples.
  double ratio() const {
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes;
    axes.computeDirect(reported);
    const Eigen::Vector2d major = axes.eigenvectors().col(1);
    return std::sqrt(major.dot(reported * major) / major.dot(sampled * major));
  }
};

// The middles of the cells in which corners were seen.
std::vector<Place> covered_places(const World& world) {
  std::vector<Place> places;
  for (int c = 0; c < static_cast<int>(world.truth.cameras.size()); ++c) {
    const Camera& camera = world.truth.cameras[c];
    const CornerEvidence evidence = *corner_evidence(world.exact.problem, world.truth, c);
    for (int row = 0; row < evidence.rows; ++row) {
      for (int column = 0; column < evidence.columns; ++column) {
        const Eigen::Vector2d pixel = middle_of_cell(camera.size, evidence.rows, evidence.columns, row, column);
        if (!evidence.covers(camera.size, pixel) || !ray_from_pixel(camera, pixel)) continue;
        for (const double range_m : kRanges_m) places.push_back({.camera = c, .pixel = pixel, .range_m = range_m});
      }
    }
  }
  return places;
}

// The point whose pixels in both solved cameras are nearest to those that the true ones see.
double triangulated_depth(const World& world, const std::vector<RigCamera>& solved, const Eigen::Vector3d& in_first,
                          const Eigen::Vector2d& pixel) {
  const Rigid3 true_motion = world.truth.camera_from_rig[1];
  const Eigen::Vector2d in_second = *pixel_from_ray(world.truth.cameras[1], true_motion * in_first);
  const auto residual = [&](const Eigen::Vector3d& x) {
    Eigen::Vector4d both;
    both << *pixel_from_ray(solved[0].camera, x) - pixel,
        *pixel_from_ray(solved[1].camera, solved[1].camera_from_rig * x) - in_second;
    return both;
  };
  Eigen::Vector3d x = in_first;
  for (int iteration = 0; iteration < 4; ++iteration) {
    Eigen::Matrix<double, 4, 3> jacobian;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d step = 1e-5 * Eigen::Vector3d::Unit(k);
      jacobian.col(k) = (residual(x + step) - residual(x - step)) / 2e-5;
    }
    x -= (jacobian.transpose() * jacobian).ldlt().solve(jacobian.transpose() * residual(x));
  }
  return x.z();
}

void add_depth(const World& world, const std::vector<RigCamera>& solved, const Covariance& known, Place& place) {
  const Eigen::Vector3d ray = *ray_from_pixel(world.truth.cameras[0], place.pixel);
  if (!std::isfinite(place.range_m) || ray.z() < 0.2) return;
  const RigCamera first{solved[0].name, world.truth.cameras[0], {}};
  const RigCamera second{solved[1].name, world.truth.cameras[1], world.truth.camera_from_rig[1]};
  const Eigen::Vector3d in_first = place.range_m * ray;
  const double sigma = stereo_depth(first, second, known, place.pixel, in_first.z()).sigma_m;
  if (!std::isfinite(sigma)) return;
  place.depth_reported += sigma * sigma;
  place.depth_sampled += std::pow(triangulated_depth(world, solved, in_first, place.pixel) - in_first.z(), 2);
}

// Solves one sample of the noise and adds what it says and what it is off by; false when the solve fails.
bool add_sample(const World& world, int seed, std::vector<Place>& places) {
  const CalibrationProblem problem = testing::with_noise(world.exact.problem, kSigma_px, static_cast<unsigned>(seed));
  BundleState state = world.truth;
  if (solve_bundle(problem, state).termination != Termination::kConverged) return false;
  const Covariance known = covariance(reduced_information(problem, state)).covariance;
  std::vector<RigCamera> solved;
  std::vector<ProjectionUncertainty> uncertain;
  std::vector<Rigid3> aligned;
  for (int c = 0; c < static_cast<int>(state.cameras.size()); ++c) {
    solved.push_back(
        {problem.cameras[c].name, state.cameras[c], state.camera_from_rig[c], corner_evidence(problem, state, c)});
    uncertain.push_back(projection_uncertainty(solved[c], known));
    aligned.push_back(testing::aligning_motion(testing::true_corners(world.exact, c), state.cameras[c]));
  }
  for (Place& place : places) {
    const int c = place.camera;
    const Eigen::Vector3d ray = *ray_from_pixel(world.truth.cameras[c], place.pixel);
    const auto seen = testing::aligned_projection(state.cameras[c], aligned[c], ray, place.range_m);
    const auto covariance = projection_covariance(uncertain[c], place.pixel, place.range_m);
    if (!seen || !covariance) return false;
    place.reported += *covariance;
    place.sampled += (*seen - place.pixel) * (*seen - place.pixel).transpose();
    if (c == 0 && solved.size() == 2) add_depth(world, solved, known, place);
  }
  return true;
}

// The ratio that is farthest from one decides.
bool print_ratios(const char* what, double range_m, const std::vector<double>& ratios, int samples) {
  const auto [least, most] = std::ranges::minmax(ratios);
  const bool holds = least >= kLeastRatio && most <= kMostRatio;
  const double mean = std::accumulate(ratios.begin(), ratios.end(), 0.0) / static_cast<double>(ratios.size());
  std::printf(
      "  %-12s at %5.1f m: reported over sampled sigma %.3f to %.3f, mean %.3f, of %zu cells, each +- %.3f (%.1f to "
      "%.1f: %s)\n",
      what, range_m, least, most, mean, ratios.size(), 1.0 / std::sqrt(2.0 * samples), kLeastRatio, kMostRatio,
      holds ? "holds" : "MISSED");
  return holds;
}

bool prove(const char* name, const World& world, int seeds) {
  std::vector<Place> places = covered_places(world);
  int samples = 0;
  for (int seed = 1; seed <= seeds; ++seed) samples += add_sample(world, seed, places);
  std::printf("%s: %d of %d samples of the noise, %.1f px\n", name, samples, seeds, kSigma_px);
  bool holds = samples == seeds;
  for (int c = 0; c < static_cast<int>(world.truth.cameras.size()); ++c) {
    for (const double range_m : kRanges_m) {
      std::vector<double> ratios;
      for (const Place& place : places) {
        if (place.camera == c && place.range_m == range_m) ratios.push_back(place.ratio());
      }
      holds = print_ratios(world.exact.problem.cameras[c].name.c_str(), range_m, ratios, samples) && holds;
    }
  }
  for (const double range_m : kRanges_m) {
    std::vector<double> ratios;
    for (const Place& place : places) {
      if (place.range_m == range_m && place.depth_sampled > 0.0) {
        ratios.push_back(std::sqrt(place.depth_reported / place.depth_sampled));
      }
    }
    if (!ratios.empty()) holds = print_ratios("stereo depth", range_m, ratios, samples) && holds;
  }
  return holds;
}

}  // namespace

int main(int argc, char** argv) {
  const int seeds = argc > 1 ? std::atoi(argv[1]) : 800;
  const int frames = argc > 2 ? std::atoi(argv[2]) : 25;
  testing::SyntheticOptions fisheye;
  fisheye.frames = frames;
  testing::SyntheticOptions stereo = fisheye;
  stereo.cameras.push_back(stereo.cameras[0]);
  stereo.cameras[1].camera_from_rig.rotation = Eigen::AngleAxisd(0.05, Eigen::Vector3d(0.1, 1.0, 0.05).normalized());
  stereo.cameras[1].camera_from_rig.translation = {-0.12, 0.01, -0.02};
  bool holds = prove("fisheye", make_world(fisheye, false), seeds);
  holds = prove("stereo head", make_world(stereo, false), seeds) && holds;
  holds = prove("rig with a laser", make_world(testing::laser_rig_options(frames, 11), true), seeds) && holds;
  return holds ? 0 : 1;
}
