// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// What solve_bundle costs: against a hand-written limit and against Ceres with a residual for each corner, by the
// number of views, of threads, of cameras, with robust loss and board shape. Candidates take turns within one run, and
// processor time counts, because other work may share the machine; only threads are measured by the clock on the wall.
// usage: bench_bundle [repetitions]
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "limit/limit.hpp"
#include "limit/per_corner.hpp"
#include "raybundle/bundle/bundle.hpp"
#include "support/clock.hpp"
#include "synthetic_world.hpp"

namespace {

using namespace raybundle;
using bench::seconds;

struct World {
  CalibrationProblem problem;
  BundleState start;
  double observations = 0.0;
};

// 14 x 10 corners through fisheye cameras side by side, the start some percent and degrees away.
World make_world(int frames, int cameras = 1) {
  testing::SyntheticOptions options;
  options.columns = 14;
  options.rows = 10;
  options.square_m = 0.025;
  options.frames = frames;
  options.noise_px = 0.3;
  options.cameras.resize(cameras);
  for (int c = 1; c < cameras; ++c) options.cameras[c].camera_from_rig.translation.x() = -0.1 * c;
  const testing::SyntheticWorld truth = testing::synthetic_world(options);
  World world{truth.problem, {truth.cameras, truth.camera_from_rig, truth.poses, truth.shapes, truth.pose_of_view, {}}};
  for (Camera& camera : world.start.cameras) {
    camera.parameters.head<2>() *= 1.05;
    camera.parameters.tail<4>().setZero();
  }
  Eigen::Matrix<double, 6, 1> motion;
  motion << 0.02, -0.01, 0.01, 0.01, 0.005, 0.02;
  for (BoardPose& pose : world.start.poses) pose.rig_from_target = perturbed(pose.rig_from_target, motion);
  mark_projectable(world.problem, world.start);
  for (const TargetView& view : world.problem.views)
    world.observations += static_cast<double>(view.observations.size());
  return world;
}

struct Candidate {
  std::string name;
  std::function<BundleSummary()> solve;
  std::vector<double> times = {};  // [s]
  BundleSummary summary = {};

  double median() const {
    std::vector<double> sorted = times;
    std::ranges::sort(sorted);
    return sorted[sorted.size() / 2];
  }
  double best() const { return *std::ranges::min_element(times); }
};

Candidate ours(std::string name, const World& world, const BundleOptions& options = {}) {
  return {std::move(name), [&world, options] {
            BundleState state = world.start;
            return solve_bundle(world.problem, state, options);
          }};
}

void race(std::vector<Candidate>& candidates, int repetitions, clockid_t clock = CLOCK_PROCESS_CPUTIME_ID) {
  for (int i = 0; i < repetitions; ++i) {
    for (Candidate& candidate : candidates) {
      const double begin = seconds(clock);
      candidate.summary = candidate.solve();
      candidate.times.push_back(seconds(clock) - begin);
    }
  }
}

// A figure against its bar; bars are upper ones unless said otherwise.
void print_figure(const char* what, double figure, double bar, bool at_least = false) {
  const bool holds = at_least ? figure >= bar : figure <= bar;
  std::printf("  %-58s %8.3f  (%s %g: %s)\n", what, figure, at_least ? "at least" : "at most", bar,
              holds ? "holds" : "MISSED");
}

void print(const Candidate& candidate, double observations) {
  std::printf("  %-34s %9.2f ms  best %9.2f ms  %6.1f ns/corner/iteration  %2d iterations  cost %.10g\n",
              candidate.name.c_str(), 1e3 * candidate.median(), 1e3 * candidate.best(),
              1e9 * candidate.median() / observations / candidate.summary.iterations, candidate.summary.iterations,
              candidate.summary.final_cost);
}

double largest_difference(const BundleState& a, const BundleState& b) {
  double largest = 0.0;
  for (std::size_t c = 0; c < a.cameras.size(); ++c) {
    const Eigen::ArrayXd x = a.cameras[c].parameters, y = b.cameras[c].parameters;
    largest = std::max(largest, ((x - y).abs() / y.abs().max(1.0)).maxCoeff());
  }
  for (std::size_t p = 0; p < a.poses.size(); ++p) {
    const Rigid3& x = a.poses[p].rig_from_target;
    const Rigid3& y = b.poses[p].rig_from_target;
    largest = std::max(largest, (x.rotation.coeffs() - y.rotation.coeffs()).cwiseAbs().maxCoeff());
    largest = std::max(largest, (x.translation - y.translation).cwiseAbs().maxCoeff());
  }
  return largest;
}

// Peak of a process that makes the problem and solves it, beyond 200 bytes for each observation.
void print_memory(int frames) {
  const pid_t child = fork();  // first of all, while this process is still small
  if (child == 0) {
    const World world = make_world(frames);
    BundleState state = world.start;
    solve_bundle(world.problem, state);
    std::printf("memory, %d views, %.0f corners: peak of a process of its own, problem included\n", frames,
                world.observations);
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    std::printf("  peak %.1f MB\n", static_cast<double>(usage.ru_maxrss) / 1024.0);
    print_figure("MB beyond 200 bytes for each corner",
                 static_cast<double>(usage.ru_maxrss) / 1024.0 - 200.0 * world.observations / 1048576.0, 50.0);
    std::fflush(stdout);
    _exit(0);
  }
  int status = 1;
  waitpid(child, &status, 0);
  if (status != 0) throw std::runtime_error("the process whose memory is measured did not get to its end");
}

void print_limit(int repetitions) {
  const World world = make_world(200);
  std::printf("200 views, %.0f corners, kannala_brandt, one thread\n", world.observations);
  std::vector<Candidate> candidates{
      ours("solve_bundle", world),
      {"hand-written limit",
       [&] {
         BundleState state = world.start;
         return limit::solve(world.problem, state);
       }},
      {"Ceres, autodiff for each corner", [&] { return limit::solve_per_corner(world.problem, world.start); }}};
  race(candidates, repetitions);
  for (const Candidate& candidate : candidates) print(candidate, world.observations);
  print_figure("solve_bundle over the limit", candidates[0].median() / candidates[1].median(), 1.5);
  BundleState a = world.start, b = world.start;
  solve_bundle(world.problem, a);
  limit::solve(world.problem, b);
  print_figure("largest difference of the answers, in 1e-9", 1e9 * largest_difference(a, b), 1.0);
}

void print_growth(int repetitions) {
  std::printf("growth with the number of views, one thread\n");
  std::vector<World> worlds;
  for (int frames : {20, 50, 200, 1000, 5000}) worlds.push_back(make_world(frames));
  std::vector<Candidate> candidates;
  for (const World& world : worlds) candidates.push_back(ours(std::to_string(world.problem.views.size()), world));
  race(candidates, std::max(3, repetitions / 4));
  Eigen::MatrixXd rows(worlds.size(), 2);
  Eigen::VectorXd logarithms(worlds.size());
  for (std::size_t i = 0; i < worlds.size(); ++i) {
    print(candidates[i], worlds[i].observations);
    rows.row(static_cast<Eigen::Index>(i)) << 1.0, std::log(worlds[i].observations);
    logarithms[static_cast<Eigen::Index>(i)] = std::log(candidates[i].median() / candidates[i].summary.iterations);
  }
  const Eigen::Vector2d line = (rows.transpose() * rows).inverse() * rows.transpose() * logarithms;
  print_figure("fitted exponent of the time for one iteration", line[1], 1.05);
}

// The wall's clock needs two processors that nobody else uses. Without them the processor time of the busier thread
// says what two threads would take, but for the time that they wait for each other.
void print_threads(int repetitions) {
  const World world = make_world(1000);
  std::printf("1000 views, wall time; and processor time of the busier thread\n");
  std::vector<double> busier;
  std::vector<Candidate> candidates{ours("one thread", world), ours("two threads", world, {.threads = 2})};
  race(candidates, std::max(10, repetitions), CLOCK_MONOTONIC);
  for (const Candidate& candidate : candidates) print(candidate, world.observations);
  const double by_wall = candidates[0].best() / candidates[1].best();
  for (Candidate& candidate : candidates) {
    candidate.solve = [solve = candidate.solve, &busier] {
      const double all = seconds(CLOCK_PROCESS_CPUTIME_ID), own = seconds(CLOCK_THREAD_CPUTIME_ID);
      const BundleSummary summary = solve();
      const double own_used = seconds(CLOCK_THREAD_CPUTIME_ID) - own;
      busier.push_back(std::max(own_used, seconds(CLOCK_PROCESS_CPUTIME_ID) - all - own_used));
      return summary;
    };
  }
  race(candidates, std::max(10, repetitions));
  double best[2] = {1e300, 1e300};
  for (std::size_t i = 0; i < busier.size(); ++i) best[i % 2] = std::min(best[i % 2], busier[i]);
  std::printf("  processor time of the busier thread: best %.2f ms with one, %.2f ms with two\n", 1e3 * best[0],
              1e3 * best[1]);
  print_figure("best with one thread over best with two, busier thread", best[0] / best[1], 1.6, true);
  print_figure("best with one thread over best with two, wall", by_wall, 1.6, true);
  BundleState one = world.start, two = world.start;
  solve_bundle(world.problem, one);
  solve_bundle(world.problem, two, {.threads = 2});
  print_figure("largest difference of the answers", largest_difference(one, two), 0.0);
}

void print_kinds(int repetitions) {
  std::printf("what else a solve may have to do, for each corner and iteration, one thread\n");
  const World plain = make_world(200), stereo = make_world(100, 2), rig = make_world(50, 4);
  const std::vector<double> observations{plain.observations, plain.observations, plain.observations,
                                         stereo.observations, rig.observations};
  std::vector<Candidate> candidates{ours("plain", plain), ours("robust loss", plain, {.robust_scale_sigma = 3.0}),
                                    ours("board shape", plain, {.estimate_shape = true}), ours("stereo", stereo),
                                    ours("rig of four cameras", rig)};
  race(candidates, std::max(3, repetitions / 2));
  const auto unit_cost = [&](std::size_t i) {
    return candidates[i].median() / observations[i] / candidates[i].summary.iterations;
  };
  for (std::size_t i = 0; i < candidates.size(); ++i) print(candidates[i], observations[i]);
  for (std::size_t i = 1; i < candidates.size(); ++i) {
    print_figure((candidates[i].name + " over plain").c_str(), unit_cost(i) / unit_cost(0), 2.0);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const int repetitions = argc > 1 ? std::atoi(argv[1]) : 20;
  print_memory(5000);
  print_limit(repetitions);
  print_growth(repetitions);
  print_threads(repetitions);
  print_kinds(repetitions);
  return 0;
}
