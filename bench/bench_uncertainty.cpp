// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Processor seconds from a solved bundle of two cameras and 200 views to the map of each camera's projection
// uncertainty: the covariance, what the corners say of each camera, and the maps themselves. Bar: 0.5 s. usage:
// bench_uncertainty [frames, default 100]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "raybundle/uncertainty/corner_evidence.hpp"
#include "raybundle/uncertainty/covariance.hpp"
#include "raybundle/uncertainty/frame_covariance.hpp"
#include "raybundle/uncertainty/projection_uncertainty.hpp"
#include "true_state.hpp"

namespace {

using namespace raybundle;

constexpr double kBar_s = 0.5;

// Processor seconds since the last call; everything here runs on one thread.
class Clock {
 public:
  double seconds() {
    const std::clock_t now = std::clock();
    const double passed = static_cast<double>(now - last_) / CLOCKS_PER_SEC;
    last_ = now;
    return passed;
  }

 private:
  std::clock_t last_ = std::clock();
};

}  // namespace

int main(int argc, char** argv) {
  testing::SyntheticOptions options;
  options.frames = argc > 1 ? std::atoi(argv[1]) : 100;
  options.columns = 14;
  options.rows = 10;
  options.noise_px = 0.2;
  options.cameras.push_back(options.cameras[0]);
  options.cameras[1].camera_from_rig.translation = {-0.12, 0.0, 0.0};
  const testing::SyntheticWorld world = testing::synthetic_world(options);
  BundleState state = testing::true_state(world);
  solve_bundle(world.problem, state);

  Clock clock;
  const ReducedInformation information = reduced_information(world.problem, state);
  const Covariance known = covariance(information).covariance;
  const double covariance_s = clock.seconds();
  double evidence_s = 0.0, map_s = 0.0;
  double largest_px = 0.0;
  for (int c = 0; c < 2; ++c) {
    clock.seconds();
    const RigCamera camera{world.problem.cameras[c].name, state.cameras[c], state.camera_from_rig[c],
                           corner_evidence(world.problem, state, c)};
    evidence_s += clock.seconds();
    const UncertaintyMap map = uncertainty_map(projection_uncertainty(camera, known), kInfinitelyFar);
    map_s += clock.seconds();
    largest_px = std::max(largest_px, map.sigma_px.array().isNaN().select(0.0, map.sigma_px).maxCoeff());
  }
  const double whole_s = covariance_s + evidence_s + map_s;
  clock.seconds();
  const bool told = covariance_by_frame(information, information_by_frame(world.problem, state)).has_value();
  const double by_frame_s = clock.seconds();

  std::printf("%zu views of two cameras, two maps of 60x45 cells, largest sigma %.3f px\n", world.problem.views.size(),
              largest_px);
  std::printf("  covariance %.4f s, corners' evidence %.4f s, maps %.4f s\n", covariance_s, evidence_s, map_s);
  std::printf("  together %.4f s (at most %.1f: %s)\n", whole_s, kBar_s, whole_s <= kBar_s ? "holds" : "MISSED");
  std::printf("  beside it, covariance by frames%s: %.4f s\n", told ? "" : " (too few frames)", by_frame_s);
  return whole_s <= kBar_s ? 0 : 1;
}
