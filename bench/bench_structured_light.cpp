// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Time of the structured-light runtime for an image of 640x480 and 304 beams, on one thread that is pinned to a
// processor: finding dots, labelling them, the whole chain from the image to points, mesh and health. What a frame
// needs is the least processor time of several passes over many different cabins, so the tail is that of the frames.
// What the machine adds, its interrupts and other work on it, is shown beside: all times, and those of one image that
// is processed again and again between the others, whose work is constant. At the end the worst image: spots
// everywhere. usage: bench_structured_light [images, default 1000] [passes, default 9]
#include <sched.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

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

double share_below(std::vector<double> times, double share) {
  std::ranges::sort(times);
  return times[static_cast<std::size_t>(share * static_cast<double>(times.size() - 1))];
}

void print(const char* what, const std::vector<double>& times, const char* end) {
  const double median = share_below(times, 0.5), tail = share_below(times, 0.999);
  std::printf("  %-36s median %.3f ms, p99.9 %.3f ms (%.2f times)%s", what, median, tail, tail / median, end);
}

// Processor time of each image in each pass [ms].
class Times {
 public:
  explicit Times(int images) : least_(images, INFINITY) {}

  template <typename Work>
  void add(int image, Work&& work) {
    const double begin = bench::seconds(CLOCK_THREAD_CPUTIME_ID);
    work();
    all_.push_back(1e3 * (bench::seconds(CLOCK_THREAD_CPUTIME_ID) - begin));
    least_[image] = std::min(least_[image], all_.back());
  }

  const std::vector<double>& all() const { return all_; }
  const std::vector<double>& least() const { return least_; }

  bool holds(const std::string& what, double bar_ms) const {
    constexpr double kTail = 1.5;
    const double median = share_below(least_, 0.5);
    const bool holds = median <= bar_ms && share_below(least_, 0.999) <= kTail * median;
    print((what + ", frames").c_str(), least_, "");
    std::printf("; at most %.1f ms and %.1f times: %s\n", bar_ms, kTail, holds ? "holds" : "MISSED");
    print((what + ", with what the machine adds").c_str(), all_, "\n");
    return holds;
  }

 private:
  std::vector<double> all_, least_;
};

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
  const int count = argc > 1 ? std::max(1, std::atoi(argv[1])) : 1000;
  const int passes = argc > 2 ? std::max(1, std::atoi(argv[2])) : 9;
  const bench::SensorInUse sensor = bench::calibrated_sensor({16, 19}, 12.0, {.tolerance_px = 1.0});
  const std::vector<testing::SpotImage> images = cabin_images(sensor, count);
  pin_to_this_processor();
  StructuredLight runtime(sensor.table), constant(sensor.table);
  DotFinder finder(sensor.table.rays.size, runtime.most_dots());
  const BeamSet beams(sensor.table);
  const BeamLattice lattice(sensor.table);
  Candidates candidates(runtime.most_dots());
  LabelWork work(runtime.most_dots(), sensor.table);
  for (int i = 0; i < 100; ++i) constant.process(images.front().view());  // the processor wakes up
  Times labelling(count), whole(count), of_constant(count);
  std::size_t dots = 0, points = 0;
  for (int pass = 0; pass < passes; ++pass) {
    for (int i = 0; i < count; ++i) {
      const GreyView image = images[i].view();
      const std::span<const Dot> found = finder.find(image);
      labelling.add(i, [&] {
        candidates.find(beams, found);
        kLabellers.front().label({lattice, sensor.table.range, candidates}, work);
      });
      whole.add(i, [&] { points += runtime.process(image).points.size(); });
      of_constant.add(i, [&] { constant.process(images.front().view()); });
      dots += found.size();
    }
  }
  const double frames = static_cast<double>(count) * passes;
  std::printf("640x480, %zu beams, %d images, %d passes, one pinned thread; %.0f dots and %.0f points in a frame\n",
              sensor.table.beams.size(), count, passes, static_cast<double>(dots) / frames,
              static_cast<double>(points) / frames);
  const bool labels = labelling.holds("labels", 0.2), chain = whole.holds("whole chain", 1.0);
  print("one image, with what the machine adds", of_constant.all(), "\n");
  const testing::SpotImage worst = worst_image(sensor.table.rays.size);
  Times of_worst(1);
  std::size_t found = 0;
  for (int i = 0; i < 50; ++i) of_worst.add(0, [&] { found = runtime.process(worst.view()).dots.size(); });
  std::printf("spots everywhere: %zu dots kept, whole chain %.3f ms\n", found, of_worst.least().front());
  return labels && chain ? EXIT_SUCCESS : EXIT_FAILURE;
}
