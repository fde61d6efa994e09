// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Laser dots in synthetic images of known truth: bias, scatter over the Cramér-Rao bound, whether the stated
// covariances are true, recall and precision, at three signal to noise ratios, with and without a laser-off partner.
// usage: prove_dots [frames of each row]
#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <string>

#include "raybundle/targets/laser_dots.hpp"
#include "spot_render.hpp"

namespace {

using namespace raybundle;
using namespace raybundle::testing;

constexpr double kMostBias = 0.02;  // pixels
constexpr double kMostOverBound = 1.5;
constexpr double kLeastFound = 0.99;
// Sigmas within which a spot's light falls on print of both kinds; without a laser-off image, those within which the
// edge's own blur, 3 sigmas wide and ten times as bright as a faint spot, reaches into the filter, which is as wide.
// Beyond, the spot counts as on even ground.
constexpr double kAcross = 3.0, kAcrossAlone = 6.0;

struct Tally {
  int spots = 0, found = 0, wrong = 0, reported = 0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double squares = 0, bound = 0, normalised = 0;  // per coordinate
  double ms = 0;
  int frames = 0;

  double bias() const { return (sum / std::max(1, found)).norm(); }
  double over_bound() const { return std::sqrt(squares / std::max(1e-12, bound)); }
  double recall() const { return found / std::max(1.0, static_cast<double>(spots)); }
  double precision() const { return 1 - wrong / std::max(1.0, static_cast<double>(reported)); }
};

// Adds the spots of a frame that are on even ground (and those across edges to another tally).
void add(const SpotFrame& frame, const FoundDots& found, double near_edge, Tally& even, Tally& across) {
  std::vector<char> taken(frame.spots.size(), 0);
  for (const Dot& dot : found.dots) {
    std::size_t nearest = 0;
    double distance = 1e9;
    for (std::size_t i = 0; i < frame.spots.size(); ++i) {
      const double d = (dot.pixel - frame.spots[i].pixel).norm();
      if (d < distance) distance = d, nearest = i;
    }
    const TrueSpot& spot = frame.spots[nearest];
    Tally& tally = spot.edge_sigmas < near_edge ? across : even;
    ++even.reported;
    if (distance > 2 * frame.sigma_px || taken[nearest]++ > 0) {
      ++even.wrong;
      continue;
    }
    const Eigen::Vector2d error = dot.pixel - spot.pixel;
    ++tally.found;
    tally.sum += error;
    tally.squares += error.squaredNorm() / 2;
    tally.bound += spot.bound_px2.trace() / 2;
    tally.normalised += error.dot(dot.covariance_px2.inverse() * error) / 2;
  }
  for (const TrueSpot& spot : frame.spots) ++(spot.edge_sigmas < near_edge ? across : even).spots;
}

bool print(const std::string& name, const Tally& tally, bool bars) {
  const bool good = !bars || (tally.bias() < kMostBias && tally.over_bound() < kMostOverBound &&
                              tally.recall() >= kLeastFound && tally.precision() >= kLeastFound);
  fmt::print("{:<34} {:>6} {:>8.4f} {:>9.3f} {:>8.3f} {:>8.4f} {:>9.4f} {:>7.1f} {}\n", name, tally.spots, tally.bias(),
             tally.over_bound(), tally.normalised / std::max(1, tally.found), tally.recall(), tally.precision(),
             tally.ms / std::max(1, tally.frames), !bars ? "no bar" : (good ? "ok" : "FAILS"));
  return good;
}

bool prove(const std::string& name, SpotScene scene, int frames, bool pair) {
  Tally even, across;
  for (int i = 0; i < frames; ++i) {
    scene.seed = static_cast<unsigned>(i + 1);
    const SpotFrame frame = render_spots(scene);
    const std::clock_t start = std::clock();
    const FoundDots found = find_dots(frame.on, pair ? &frame.off : nullptr);
    even.ms += 1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    ++even.frames;
    add(frame, found, pair ? kAcross : kAcrossAlone, even, across);
  }
  const bool good = print(name, even, true);
  if (across.spots > 0) print("  of them across a printed edge", across, false);
  return good;
}

}  // namespace

int main(int argc, char** argv) {
  const int frames = argc > 1 ? std::max(1, std::atoi(argv[1])) : 6;
  fmt::print("{:<34} {:>6} {:>8} {:>9} {:>8} {:>8} {:>9} {:>7}\n", "scene", "spots", "bias px", "sigma/CRB", "nse",
             "recall", "precision", "ms");
  bool good = true;
  for (const bool pair : {true, false}) {
    for (const double snr : {5.0, 10.0, 30.0}) {
      SpotScene scene;
      scene.snr = snr;
      const std::string kind = pair ? "on and off" : "on alone";
      good &= prove(fmt::format("{}, SNR {}, print", kind, snr), scene, frames, pair);
      scene.square_px = 0;
      scene.rows = scene.columns = 11;
      good &= prove(fmt::format("{}, SNR {}, paper, 121 spots", kind, snr), scene, frames, pair);
    }
  }
  SpotScene scene;
  scene.bits = 12;
  scene.off_scale = 0.8;
  scene.paper_grey = 40;
  good &= prove("on and off at 0.8, SNR 10, 12 bits", scene, frames, true);
  fmt::print("bars: bias below {} px, sigma over the bound below {}, recall and precision at least {}\n", kMostBias,
             kMostOverBound, kLeastFound);
  return good ? 0 : 1;
}
