// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// What the way to the optimum costs beside the last step of it: start values from observations alone, and the whole of
// calibrate(), against one plain solve_bundle from the same start. Processor time, one thread, best of the repetitions.
// usage: bench_start [repetitions] [words that the names of the worlds must hold]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>

#include "raybundle/bundle/bundle.hpp"
#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/calibrate/lens_prior.hpp"
#include "raybundle/initialize/camera_start.hpp"
#include "support/clock.hpp"
#include "synthetic_world.hpp"

namespace {

using namespace raybundle;

// Other work on the machine must not count: processor time of this process.
double milliseconds_now() { return 1e3 * bench::seconds(CLOCK_PROCESS_CPUTIME_ID); }

double best_ms(int repetitions, const std::function<void()>& work) {
  double best = 1e300;
  for (int i = 0; i < repetitions; ++i) {
    const double begin = milliseconds_now();
    work();
    best = std::min(best, milliseconds_now() - begin);
  }
  return best;
}

// 14 x 10 corners, 0.3 px noise: a fisheye of 130 degrees, a rational lens of 70 degrees, and two of the former.
testing::SyntheticOptions options_of(const std::string& kind, int views, double outliers) {
  testing::SyntheticOptions options;
  options.columns = 14;
  options.rows = 10;
  options.square_m = 0.025;
  options.frames = views;
  options.noise_px = 0.3;
  options.outlier_fraction = outliers;
  options.max_tilt_rad = 0.7;
  testing::SyntheticCamera& camera = options.cameras[0];
  if (kind == "rational_70") {
    camera.model = "rational";
    camera.focal_px = 910.0;
    options.max_off_axis_rad = 0.35;
    options.min_distance_m = 0.4;
  } else {
    camera.focal_px = 540.0;
    options.max_off_axis_rad = 0.7;
  }
  if (kind == "stereo_130") {
    camera.camera_from_rig = Rigid3{};
    options.cameras.push_back(camera);
    options.cameras[1].camera_from_rig.translation.x() = -0.12;
    options.frames = views / 2;
  }
  return options;
}

// The state that the starts of the cameras give; each camera by itself.
BundleState started(const CalibrationProblem& problem, const std::vector<CameraStart>& starts) {
  BundleState state;
  state.shapes.resize(problem.targets.size());
  state.camera_from_rig.resize(problem.cameras.size());
  for (const CameraStart& start : starts) state.cameras.push_back(start.camera);
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    const auto& pose = starts[problem.views[v].camera].camera_from_target[v];
    state.pose_of_view.push_back(pose ? static_cast<int>(state.poses.size()) : -1);
    if (pose) state.poses.push_back({problem.views[v].frame, problem.views[v].target, *pose});
  }
  mark_projectable(problem, state);
  return state;
}

void measure(const std::string& kind, int views, double outliers, int repetitions) {
  const CalibrationProblem problem = testing::synthetic_world(options_of(kind, views, outliers)).problem;
  std::vector<CameraStart> starts;
  const double start_ms = best_ms(repetitions, [&] {
    starts.clear();
    for (int c = 0; c < static_cast<int>(problem.cameras.size()); ++c) starts.push_back(initialize_camera(problem, c));
  });
  const BundleState start = started(problem, starts);
  CalibrationProblem weighed = problem;
  weigh_lens_priors(weighed, start);
  int iterations = 0;
  const double solve_ms = best_ms(repetitions, [&] {
    BundleState state = start;
    iterations = solve_bundle(weighed, state).iterations;
  });
  const double whole_ms = best_ms(repetitions, [&] { calibrate(problem, {.threads = 1}); });
  // The bar is that of the start for 200 views, where what is paid once weighs neither much nor nothing.
  const char* verdict = views != 200 ? "" : start_ms <= solve_ms ? "  bar 1x: passed" : "  bar 1x: FAILED";
  std::printf("%-12s %5zu %3.0f %%  whole %8.2f ms %5.2fx   solve %8.2f ms %3d iterations   start %8.2f ms %5.2fx%s\n",
              kind.c_str(), problem.views.size(), 100 * outliers, whole_ms, whole_ms / solve_ms, solve_ms, iterations,
              start_ms, start_ms / solve_ms, verdict);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const int repetitions = argc > 1 ? std::atoi(argv[1]) : 3;
  const std::string wanted = argc > 2 ? argv[2] : "";
  for (const char* kind : {"fisheye_130", "rational_70", "stereo_130"}) {
    if (std::string(kind).find(wanted) == std::string::npos) continue;
    for (const int views : {20, 200, 1000}) {
      for (const double outliers : {0.0, 0.01}) measure(kind, views, outliers, repetitions);
    }
  }
  return 0;
}
