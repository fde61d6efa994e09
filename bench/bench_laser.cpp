// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// What the joint solve of cameras, boards and laser beams costs: 304 beams before two cameras, by the number of views
// and of threads. The start is what a calibration has before the joint solve: cameras and boards solved from the
// corners alone, beams as lines through their dots. By the clock on the wall, and by processor time beside it, because
// other work may share the machine.
// usage: bench_laser [repetitions]
#include <malloc.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <vector>

#include "laser_world.hpp"
#include "raybundle/bundle/bundle.hpp"
#include "raybundle/bundle/information.hpp"
#include "support/clock.hpp"

namespace {

using namespace raybundle;
using bench::seconds;

struct World {
  int frames = 0;
  CalibrationProblem problem;
  BundleState start;
  double dots = 0.0;
};

// Where the ray of a dot meets the plane of its board, in the rig's frame.
std::optional<Eigen::Vector3d> spot(const World& world, const BundleState& state, int view, const Dot& dot) {
  const TargetView& seen = world.problem.views[view];
  const auto ray = ray_from_pixel(state.cameras[seen.camera], dot.pixel);
  if (!ray || state.pose_of_view[view] < 0) return {};
  const Rigid3& rig_from_target = state.poses[state.pose_of_view[view]].rig_from_target;
  const Rigid3 target_from_camera = (state.camera_from_rig[seen.camera] * rig_from_target).inverse();
  const Eigen::Vector3d direction = target_from_camera.rotation * *ray;
  const double distance = -target_from_camera.translation.z() / direction.z();
  return rig_from_target * (target_from_camera.translation + distance * direction);
}

void start_beams(World& world) {
  const int beams = world.problem.laser->grid.size();
  std::vector<std::vector<Eigen::Vector3d>> hits(beams);
  for (int v = 0; v < static_cast<int>(world.problem.views.size()); ++v) {
    for (const Dot& dot : world.problem.views[v].dots) {
      if (const auto x = spot(world, world.start, v, dot)) hits[dot.beam].push_back(*x);
      world.dots += 1.0;
    }
  }
  world.start.beams.resize(beams);
  for (int b = 0; b < beams; ++b) {
    if (hits[b].size() < 3) continue;
    Eigen::Matrix3Xd points(3, hits[b].size());
    for (std::size_t i = 0; i < hits[b].size(); ++i) points.col(static_cast<Eigen::Index>(i)) = hits[b][i];
    world.start.beams[b] = line_through(points, {}, Eigen::Vector3d::UnitZ());
  }
  mark_dots(world.problem, world.start);
}

World make_world(int frames) {
  testing::SyntheticOptions options = testing::laser_rig_options(frames, 7);
  options.noise_px = 0.1;
  options.cameras.resize(2, options.cameras[0]);
  options.cameras[1].camera_from_rig.translation << -0.12, 0.003, 0.001;
  testing::SyntheticWorld truth = testing::synthetic_world(options);
  testing::add_laser(truth, {.grid = {.rows = 16, .columns = 19}, .noise_px = 0.1, .labelled = true});
  World world{.frames = frames, .problem = truth.problem, .start = {}};
  world.start = {truth.cameras, truth.camera_from_rig, truth.poses, truth.shapes, truth.pose_of_view, {}, {}, {}};
  mark_projectable(world.problem, world.start);
  solve_bundle(world.problem, world.start);
  start_beams(world);
  return world;
}

struct Run {
  std::vector<double> wall, processor;  // [s]
  BundleSummary summary;
  BundleState answer;

  static double median(std::vector<double> values) {
    std::ranges::sort(values);
    return values[values.size() / 2];
  }
};

void solve(const World& world, int threads, Run& run) {
  run.answer = world.start;
  const double wall = seconds(CLOCK_MONOTONIC), processor = seconds(CLOCK_PROCESS_CPUTIME_ID);
  run.summary = solve_bundle(world.problem, run.answer, {.threads = threads});
  run.wall.push_back(seconds(CLOCK_MONOTONIC) - wall);
  run.processor.push_back(seconds(CLOCK_PROCESS_CPUTIME_ID) - processor);
}

void print_figure(const char* what, double figure, double bar) {
  std::printf("  %-62s %8.3f  (at most %g: %s)\n", what, figure, bar, figure <= bar ? "holds" : "MISSED");
}

bool same_bits(const BundleState& a, const BundleState& b) {
  for (std::size_t i = 0; i < a.beams.size(); ++i) {
    if (a.beams[i] && (a.beams[i]->point != b.beams[i]->point || a.beams[i]->direction != b.beams[i]->direction)) {
      return false;
    }
  }
  return true;
}

// Slope of the logarithm of the time for one iteration over that of the views, from one of the worlds on.
double exponent(const std::vector<World>& worlds, const std::vector<Run>& runs, std::size_t first) {
  const auto count = static_cast<Eigen::Index>(worlds.size() - first);
  Eigen::MatrixX2d rows(count, 2);
  Eigen::VectorXd logarithms(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Run& run = runs[first + i];
    rows.row(i) << 1.0, std::log(worlds[first + i].frames);
    logarithms[i] = std::log(Run::median(run.processor) / run.summary.iterations);
  }
  const Eigen::Vector2d line = (rows.transpose() * rows).inverse() * rows.transpose() * logarithms;
  return line[1];
}

// From now on the peak of this process is counted from what it holds by now, and not from what it has held [proc(5)].
void forget_peak() {
  malloc_trim(0);  // what was freed is no longer held
  std::ofstream file("/proc/self/clear_refs");
  file << 5 << std::flush;
  if (!file) throw std::runtime_error("/proc/self/clear_refs: cannot be written");
}

// Peak of a joint solve over what its problem and start hold.
void print_memory(int frames) {
  std::fflush(stdout);
  const pid_t child = fork();  // first of all, while this process is still small
  if (child == 0) {
    const World world = make_world(frames);
    forget_peak();
    rusage before{}, after{};
    getrusage(RUSAGE_SELF, &before);
    BundleState state = world.start;
    solve_bundle(world.problem, state);
    getrusage(RUSAGE_SELF, &after);
    std::printf("memory, %d views by each camera, %.0f dots\n", frames, world.dots);
    print_figure("bytes of the joint solve for each dot",
                 1024.0 * static_cast<double>(after.ru_maxrss - before.ru_maxrss) / world.dots, 500.0);
    std::fflush(stdout);
    _exit(0);
  }
  int status = 1;
  waitpid(child, &status, 0);
  if (status != 0) throw std::runtime_error("the process whose memory is measured did not get to its end");
}

}  // namespace

int main(int argc, char** argv) {
  const int repetitions = argc > 1 ? std::atoi(argv[1]) : 5;
  print_memory(500);
  std::vector<World> worlds;
  for (const int frames : {20, 60, 200, 500, 1000}) worlds.push_back(make_world(frames));
  std::vector<Run> one(worlds.size()), two(worlds.size());
  for (int i = 0; i < repetitions; ++i) {
    for (std::size_t w = 0; w < worlds.size(); ++w) {
      solve(worlds[w], 1, one[w]);
      solve(worlds[w], 2, two[w]);
    }
  }
  std::printf("joint solve, 304 beams, two cameras\n");
  for (std::size_t w = 0; w < worlds.size(); ++w) {
    const double wall_one = Run::median(one[w].wall), wall_two = Run::median(two[w].wall);
    const int iterations = one[w].summary.iterations;
    std::printf(
        "  %3d views %6.0f dots: wall %8.1f ms with one thread, %8.1f ms with two; processor %8.1f and %8.1f ms; "
        "%2d iterations of %6.1f ms; cost %.6f; bits with two: %s\n",
        worlds[w].frames, worlds[w].dots, 1e3 * wall_one, 1e3 * wall_two, 1e3 * Run::median(one[w].processor),
        1e3 * Run::median(two[w].processor), iterations, 1e3 * wall_one / iterations, one[w].summary.final_cost,
        same_bits(one[w].answer, two[w].answer) ? "the same" : "OTHERS");
  }
  print_figure("seconds on the wall with two threads, 60 views", Run::median(two[1].wall), 1.0);
  print_figure("the same in processor time of both, whatever else runs", Run::median(two[1].processor), 1.0);
  // With few poses they are kept and the beams are eliminated: faster than the law for many of them, which is that of
  // a dense factor of all beams and a step for each pose.
  std::printf("  fitted exponent of the processor time for one iteration, all sizes: %.3f\n", exponent(worlds, one, 0));
  print_figure("fitted exponent from 200 views on", exponent(worlds, one, 2), 1.05);
  const double begin = seconds(CLOCK_MONOTONIC);
  beam_covariances(worlds[1].problem, one[1].answer, {.threads = 2});
  std::printf("  covariances of all beams, 60 views: %.1f ms on the wall with two threads\n",
              1e3 * (seconds(CLOCK_MONOTONIC) - begin));
  return 0;
}
