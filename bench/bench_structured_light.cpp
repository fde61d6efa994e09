// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Time of the structured-light runtime for an image of 640x480 and 304 beams, on one thread that is pinned to a
// processor: finding dots, labelling them, the whole chain from the image to points, mesh and health. Wall-clock time
// of every frame; processor time beside it, because other work may share the machine.
// usage: bench_structured_light [frames, default 5000]
#include <sched.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "raybundle/structured_light/structured_light.hpp"
#include "sensor_worlds.hpp"
#include "spot_image.hpp"
#include "support/clock.hpp"

namespace {

using namespace raybundle;

void pin_to_this_processor() {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(sched_getcpu(), &set);
  if (sched_setaffinity(0, sizeof set, &set) != 0) std::printf("  the thread could not be pinned\n");
}

struct Times {
  std::vector<double> wall, processor;  // [ms]

  template <typename Work>
  void add(Work&& work) {
    const double cpu = bench::seconds(CLOCK_THREAD_CPUTIME_ID), begin = bench::seconds(CLOCK_MONOTONIC);
    work();
    wall.push_back(1e3 * (bench::seconds(CLOCK_MONOTONIC) - begin));
    processor.push_back(1e3 * (bench::seconds(CLOCK_THREAD_CPUTIME_ID) - cpu));
  }
};

double share_below(std::vector<double> times, double share) {
  std::ranges::sort(times);
  return times[static_cast<std::size_t>(share * static_cast<double>(times.size() - 1))];
}

bool print(const char* what, const Times& times, double bar_ms) {
  bool holds = true;
  for (const auto& [clock, values] : {std::pair("wall", &times.wall), std::pair("processor", &times.processor)}) {
    const double median = share_below(*values, 0.5), tail = share_below(*values, 0.999);
    std::printf("  %-12s %-9s median %.3f ms, p99.9 %.3f ms (%.2f times)\n", what, clock, median, tail, tail / median);
  }
  const double median = share_below(times.processor, 0.5), tail = share_below(times.processor, 0.999);
  if (bar_ms > 0.0) {
    holds = median <= bar_ms && tail <= 1.5 * median;
    std::printf("  %-12s at most %.1f ms, p99.9 at most 1.5 times the median, of processor time: %s\n", what, bar_ms,
                holds ? "holds" : "MISSED");
  }
  return holds;
}

}  // namespace

int main(int argc, char** argv) {
  const int frames = argc > 1 ? std::max(100, std::atoi(argv[1])) : 5000;
  const bench::SensorInUse sensor = bench::calibrated_sensor({16, 19}, 12.0, {.tolerance_px = 1.0});
  constexpr int kImages = 8;
  std::vector<testing::SpotImage> images;
  for (int i = 0; i < kImages; ++i) {
    Random random(3, i);
    const auto dots = dots_in(testing::CabinScene(i), sensor.camera, sensor.beams, sensor.table.grid, {}, random);
    images.emplace_back(sensor.table.rays.size, dots, true, testing::LightOptions{.sun = 60.0}, random);
  }
  pin_to_this_processor();
  StructuredLight runtime(sensor.table);
  DotFinder finder(sensor.table.rays.size, runtime.most_dots());
  const BeamSet beams(sensor.table);
  const BeamLattice lattice(sensor.table);
  Candidates candidates(runtime.most_dots());
  LabelWork work(runtime.most_dots(), sensor.table);
  Times finding, labelling, whole;
  std::size_t dots = 0, points = 0;
  for (int frame = -100; frame < frames; ++frame) {  // the first hundred warm up
    const GreyView image = images[(frame + 100) % kImages].view();
    std::span<const Dot> found;
    Times of_finding, of_labelling, of_whole;
    of_finding.add([&] { found = finder.find(image); });
    of_labelling.add([&] {
      candidates.find(beams, found);
      kLabellers.front().label({lattice, sensor.table.range, candidates}, work);
    });
    of_whole.add([&] { points += runtime.process(image).points.size(); });
    dots += found.size();
    if (frame < 0) continue;
    for (const auto& [from, to] :
         {std::pair(&of_finding, &finding), {&of_labelling, &labelling}, {&of_whole, &whole}}) {
      to->wall.push_back(from->wall[0]);
      to->processor.push_back(from->processor[0]);
    }
  }
  std::printf("640x480, %zu beams, %d frames, one pinned thread; %.0f dots and %.0f points in a frame\n",
              sensor.table.beams.size(), frames, static_cast<double>(dots) / (frames + 100),
              static_cast<double>(points) / (frames + 100));
  print("dots", finding, 0.0);
  const bool labels = print("labels", labelling, 0.2), chain = print("whole chain", whole, 1.0);
  return labels && chain ? EXIT_SUCCESS : EXIT_FAILURE;
}
