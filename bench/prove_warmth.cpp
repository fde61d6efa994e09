// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// A sensor that is started with a laser warmer or colder than at its calibration: how many dots get their beam in the
// first frame and in the twelve from there, how many labels are wrong, and whether the stated covariance covers the
// errors of depth. Simulated are dots in cabins, as for the labels, with our own calibration; every start has cabins of
// its own. Beside the counts: how many starts the watch took for a projector that has turned.
// usage: prove_warmth [starts, default 20]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "cabin_scene.hpp"
#include "raybundle/structured_light/structured_light.hpp"
#include "sensor_worlds.hpp"

namespace {

using namespace raybundle;

constexpr int kFrames = 12;

struct Count {
  long possible = 0, right = 0, wrong = 0, covered = 0;  // covered: right, and within three sigmas of the true depth

  static double percent(long part, long whole) {
    return 100.0 * static_cast<double>(part) / static_cast<double>(std::max(1L, whole));
  }
  double recall() const { return percent(right, possible); }
  double wrong_share() const { return percent(wrong, right + wrong); }
  double covered_share() const { return percent(covered, right); }
};

void count_frame(const bench::SensorInUse& sensor, const std::vector<testing::SceneDot>& dots, const LaserFrame& frame,
                 Count& count) {
  const SensorRange& range = sensor.table.range;
  for (const testing::SceneDot& dot : dots) {
    const double depth = dot.x_in_camera.z();
    count.possible += dot.beam != kUnlabelled && depth >= range.nearest_m && depth <= range.farthest_m;
  }
  for (const LaserPoint& point : frame.points) {
    const testing::SceneDot& dot = dots[point.dot];
    if (frame.dots[point.dot].beam != dot.beam) {
      ++count.wrong;
      continue;
    }
    ++count.right;
    count.covered += std::abs(point.x_in_camera.z() - dot.x_in_camera.z()) <= 3.0 * std::sqrt(point.covariance(2, 2));
  }
}

bool prove_starts(const bench::SensorInUse& sensor, double warmer_K, int starts) {
  const std::vector<EmittedBeam> beams = beams_of(warmer(*sensor.rig.emitter, warmer_K));
  Count first, all;
  int alarms = 0;
  for (int start = 0; start < starts; ++start) {
    StructuredLight runtime(sensor.table);
    State state = State::kOk;
    for (int frame = 0; frame < kFrames; ++frame) {
      const int s = start * kFrames + frame;
      Random random(78, s);
      const auto dots = dots_in(testing::CabinScene(5000 + s), sensor.camera, beams, sensor.table.grid, {}, random);
      std::vector<Dot> found;
      for (const testing::SceneDot& dot : dots) found.push_back(dot.dot);
      const LaserFrame& seen = runtime.process(found);
      state = seen.state;
      if (frame == 0) count_frame(sensor, dots, seen, first);
      count_frame(sensor, dots, seen, all);
    }
    alarms += state == State::kInvalid;
  }
  const bool holds = all.wrong_share() <= 0.1 && all.recall() >= 98.0 && alarms == 0;
  std::printf(
      "  laser %+3.0f K: first frame recall %6.2f %%, wrong %6.3f %%; %d frames recall %6.2f %%, wrong %6.3f %%, "
      "within three sigmas %6.2f %%; %d false alarms  %s\n",
      warmer_K, first.recall(), first.wrong_share(), kFrames, all.recall(), all.wrong_share(), all.covered_share(),
      alarms, holds ? "pass" : "FAIL");
  std::fflush(stdout);
  return holds;
}

}  // namespace

int main(int argc, char** argv) {
  const int starts = argc > 1 ? std::max(1, std::atoi(argv[1])) : 20;
  bool passed = true;
  for (const LaserGrid grid : {LaserGrid{11, 11}, LaserGrid{16, 19}}) {
    const bench::SensorInUse sensor = bench::calibrated_sensor(grid, 12.0, {.tolerance_px = 1.0});
    std::printf("%dx%d, %d starts; bars for all frames: recall at least 98 %%, wrong at most 0.1 %%, no false alarm\n",
                grid.columns, grid.rows, starts);
    for (const double warmer_K : {0.0, 10.0, -10.0, 20.0, -20.0, 40.0, -40.0, 60.0, -60.0}) {
      passed &= prove_starts(sensor, warmer_K, starts);
    }
  }
  return passed ? EXIT_SUCCESS : EXIT_FAILURE;
}
