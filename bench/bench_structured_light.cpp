// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Time of the structured-light runtime for an image of 640x480 and 304 beams, on one thread that is pinned to a
// processor: finding dots, labelling them, the whole chain from the image to points, mesh and health. Wall-clock time
// of every frame; processor time beside it, because other work may share the machine. As a control a second
// chain gets the same image again and again between the frames: its tail is the machine's, for its work is constant.
// What the images make of the time is seen in the least time of each. At the end the worst image: spots everywhere.
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

// Of the least time of each image: the slowest over the median one.
double slowest_image(const std::vector<double>& times, int images) {
  std::vector<double> least(images, INFINITY);
  for (std::size_t i = 0; i < times.size(); ++i) least[i % images] = std::min(least[i % images], times[i]);
  return std::ranges::max(least) / share_below(least, 0.5);
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

std::vector<testing::SpotImage> cabin_images(const bench::SensorInUse& sensor, int count) {
  std::vector<testing::SpotImage> images;
  for (int i = 0; i < count; ++i) {
    Random random(3, i);
    const auto dots = dots_in(testing::CabinScene(i), sensor.camera, sensor.beams, sensor.table.grid, {}, random);
    images.emplace_back(sensor.table.rays.size, dots, true, testing::LightOptions{.sun = 60.0}, random);
  }
  return images;
}

// Spots wherever one has room.
testing::SpotImage worst_image(const ImageSize& size) {
  Random random(4);
  std::vector<testing::SceneDot> dots;
  for (int v = 8; v < size.height - 8; v += 7) {
    for (int u = 8; u < size.width - 8; u += 7) dots.push_back({.dot = {.pixel = {u, v}}, .x_in_camera = {0, 0, 1}});
  }
  return {size, dots, true, {}, random};
}

}  // namespace

int main(int argc, char** argv) {
  const int frames = argc > 1 ? std::max(100, std::atoi(argv[1])) : 5000;
  const bench::SensorInUse sensor = bench::calibrated_sensor({16, 19}, 12.0, {.tolerance_px = 1.0});
  constexpr int kImages = 20, kWarmUp = 100;  // frames
  const std::vector<testing::SpotImage> images = cabin_images(sensor, kImages);
  pin_to_this_processor();
  StructuredLight runtime(sensor.table), constant(sensor.table);
  DotFinder finder(sensor.table.rays.size, runtime.most_dots());
  const BeamSet beams(sensor.table);
  const BeamLattice lattice(sensor.table);
  Candidates candidates(runtime.most_dots());
  LabelWork work(runtime.most_dots(), sensor.table);
  Times finding, labelling, whole, of_constant;
  std::size_t dots = 0, points = 0;
  for (int frame = -kWarmUp; frame < frames; ++frame) {
    if (frame == 0) finding = labelling = whole = of_constant = {};
    const GreyView image = images[(frame + kWarmUp) % kImages].view();
    std::span<const Dot> found;
    finding.add([&] { found = finder.find(image); });
    labelling.add([&] {
      candidates.find(beams, found);
      kLabellers.front().label({lattice, sensor.table.range, candidates}, work);
    });
    whole.add([&] { points += runtime.process(image).points.size(); });
    of_constant.add([&] { constant.process(images.front().view()); });
    dots += found.size();
  }
  std::printf("640x480, %zu beams, %d frames, one pinned thread; %.0f dots and %.0f points in a frame\n",
              sensor.table.beams.size(), frames, static_cast<double>(dots) / (frames + kWarmUp),
              static_cast<double>(points) / (frames + kWarmUp));
  print("one image", of_constant, 0.0);
  print("dots", finding, 0.0);
  const bool labels = print("labels", labelling, 0.2), chain = print("whole chain", whole, 1.0);
  std::printf("slowest image over the median one, least times: labels %.2f, whole chain %.2f\n",
              slowest_image(labelling.processor, kImages), slowest_image(whole.processor, kImages));
  const testing::SpotImage worst = worst_image(sensor.table.rays.size);
  Times of_worst;
  std::size_t found = 0;
  for (int i = 0; i < 50; ++i) of_worst.add([&] { found = runtime.process(worst.view()).dots.size(); });
  std::printf("spots everywhere: %zu dots kept, whole chain %.3f ms of processor time\n", found,
              share_below(of_worst.processor, 0.5));
  return labels && chain ? EXIT_SUCCESS : EXIT_FAILURE;
}
