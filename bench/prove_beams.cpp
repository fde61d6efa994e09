// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Whether beams scatter as much as their covariance says, and no more than the Cramér-Rao bound of the whole problem
// allows: one world of cameras, boards and beams, observed again and again with other noise of 0.1 px, each time solved
// for everything. The bound is the covariance at the truth.
// usage: prove_beams [seeds, default 200] [frames, default 20]
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "laser_world.hpp"
#include "raybundle/bundle/bundle.hpp"
#include "raybundle/bundle/information.hpp"

namespace {

using namespace raybundle;

constexpr double kSigma_px = 0.1;
constexpr int kLeastPoses = 4;  // that met a beam: with fewer the truth is no longer near in the sense of the bound

struct World {
  testing::SyntheticWorld exact;
  BundleState truth;
  std::vector<std::optional<BeamCovariance>> bound;
};

World make_world(int frames, int cameras, LaserGrid grid) {
  testing::SyntheticOptions options = testing::laser_rig_options(frames, 3);
  options.cameras.resize(cameras, options.cameras[0]);
  for (int c = 1; c < cameras; ++c) options.cameras[c].camera_from_rig.translation.x() = -0.12 * c;
  World world{.exact = testing::synthetic_world(options), .truth = {}, .bound = {}};
  const testing::LaserTruth laser = testing::add_laser(world.exact, {.grid = grid, .noise_px = 0.0, .labelled = true});
  for (TargetView& view : world.exact.problem.views) {
    for (Observation& observation : view.observations) observation.sigma_px = kSigma_px;
    for (Dot& dot : view.dots) dot.covariance_px2 = kSigma_px * kSigma_px * Eigen::Matrix2d::Identity();
  }
  world.truth = {world.exact.cameras,
                 world.exact.camera_from_rig,
                 world.exact.poses,
                 world.exact.shapes,
                 world.exact.pose_of_view,
                 {},
                 laser.lines,
                 {}};
  std::vector<std::vector<int>> poses(laser.lines.size());
  for (std::size_t v = 0; v < world.exact.problem.views.size(); ++v) {
    for (const Dot& dot : world.exact.problem.views[v].dots) poses[dot.beam].push_back(world.truth.pose_of_view[v]);
  }
  for (std::size_t b = 0; b < poses.size(); ++b) {
    std::ranges::sort(poses[b]);
    poses[b].erase(std::ranges::unique(poses[b]).begin(), poses[b].end());
    if (static_cast<int>(poses[b].size()) < kLeastPoses) world.truth.beams[b].reset();
  }
  mark_projectable(world.exact.problem, world.truth);
  mark_dots(world.exact.problem, world.truth);
  // Points amid their hits, as those of every answer: a solve that starts at its optimum moves nothing else.
  solve_bundle(world.exact.problem, world.truth);
  world.bound = beam_covariances(world.exact.problem, world.truth);
  return world;
}

// Sums over the seeds, for one beam.
struct Scatter {
  Eigen::Array4d squared = Eigen::Array4d::Zero();   // of the errors
  Eigen::Array4d reported = Eigen::Array4d::Zero();  // variances
};

struct Proof {
  std::vector<Scatter> beams;      // by LaserGrid::index
  std::vector<double> normalised;  // squared errors over what the covariance says, each seed's mean over the beams
  int failed = 0;
};

Proof prove(const World& world, int seeds) {
  Proof proof;
  proof.beams.resize(world.truth.beams.size());
  for (int seed = 1; seed <= seeds; ++seed) {
    const CalibrationProblem problem = testing::with_noise(world.exact.problem, kSigma_px, static_cast<unsigned>(seed));
    BundleState state = world.truth;
    if (solve_bundle(problem, state).termination != Termination::kConverged) ++proof.failed;
    const auto covariances = beam_covariances(problem, state);
    double normalised = 0.0;
    int count = 0;
    for (std::size_t b = 0; b < covariances.size(); ++b) {
      if (!covariances[b]) continue;
      // By the motion of the true beam, whose point lies at the same place but for a shift along the beam.
      Line3 beam = *state.beams[b];
      beam.point = beam.at((world.truth.beams[b]->point - beam.point).dot(beam.direction));
      const Eigen::Vector4d error = motion_between(*world.truth.beams[b], beam);
      const Eigen::Matrix4d& covariance = covariances[b]->of_beam;
      proof.beams[b].squared += error.array().square();
      proof.beams[b].reported += covariance.diagonal().array();
      normalised += error.dot(covariance.ldlt().solve(error));
      count += 4;
    }
    proof.normalised.push_back(normalised / count);
  }
  return proof;
}

bool print_figure(const char* what, double figure, double low, double high) {
  const bool holds = figure >= low && figure <= high;
  std::printf("  %-66s %7.3f  (%.3f to %.3f: %s)\n", what, figure, low, high, holds ? "holds" : "MISSED");
  return holds;
}

bool print(const char* name, const World& world, int seeds) {
  const Proof proof = prove(world, seeds);
  Eigen::Array4d scatter = Eigen::Array4d::Zero(), allowed = Eigen::Array4d::Zero();
  double least = INFINITY, most = 0.0;
  int beams = 0;
  for (std::size_t b = 0; b < proof.beams.size(); ++b) {
    if (!world.bound[b]) continue;
    ++beams;
    const Scatter& sums = proof.beams[b];
    const double ratio = std::sqrt((sums.squared / sums.reported).mean());
    least = std::min(least, ratio);
    most = std::max(most, ratio);
    scatter += sums.squared / sums.reported;
    allowed += sums.squared / (seeds * world.bound[b]->of_beam.diagonal().array());
  }
  std::printf("%s: %d beams, %d seeds\n", name, beams, seeds);
  bool holds = print_figure("solves that did not converge", proof.failed, 0, 0);
  const char* names[4] = {"offset 1", "offset 2", "slope 1", "slope 2"};
  for (int k = 0; k < 4; ++k) {
    const std::string what = fmt::format("scatter over reported sigma, {}, all beams", names[k]);
    holds = print_figure(what.c_str(), std::sqrt(scatter[k] / beams), 0.9, 1.1) && holds;
  }
  double mean = 0.0, variance = 0.0;
  for (const double value : proof.normalised) mean += value / seeds;
  for (const double value : proof.normalised) variance += (value - mean) * (value - mean) / (seeds - 1);
  const double interval = 2.576 * std::sqrt(variance / seeds);  // 99 %; the beams of one seed hang together
  holds = print_figure("normalised squared error", mean, 1.0 - interval, 1.0 + interval) && holds;
  holds = print_figure("scatter over the Cramer-Rao bound", std::sqrt(allowed.mean() / beams), 0.0, 1.05) && holds;
  // Chance alone moves the ratio of one parameter by one part in sqrt(2 seeds).
  std::printf("  single beams, four parameters together: scatter over reported sigma %.3f to %.3f\n", least, most);
  return holds;
}

}  // namespace

int main(int argc, char** argv) {
  const int seeds = argc > 1 ? std::atoi(argv[1]) : 200;
  const int frames = argc > 2 ? std::atoi(argv[2]) : 20;
  const bool one = print("11x11, one camera", make_world(frames, 1, {.rows = 11, .columns = 11}), seeds);
  const bool two = print("16x19, two cameras", make_world(frames, 2, {.rows = 16, .columns = 19}), seeds);
  return one && two ? 0 : 1;
}
