// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/synthetic/simulate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/board_surface.hpp"

namespace raybundle::testing {
namespace {

SimulatedRig rig_named(const std::string& name) { return read_rig(RAYBUNDLE_SOURCE_DIR "/datasets/rigs/" + name); }

bool same_bits(const TargetView& a, const TargetView& b) {
  if (a.observations.size() != b.observations.size() || a.dots.size() != b.dots.size()) return false;
  for (std::size_t i = 0; i < a.observations.size(); ++i) {
    if (a.observations[i].pixel != b.observations[i].pixel) return false;
  }
  for (std::size_t i = 0; i < a.dots.size(); ++i) {
    if (a.dots[i].pixel != b.dots[i].pixel || a.dots[i].beam != b.dots[i].beam) return false;
  }
  return true;
}

bool same_bits(const Simulation& a, const Simulation& b) {
  if (a.problem.views.size() != b.problem.views.size()) return false;
  for (std::size_t i = 0; i < a.problem.views.size(); ++i) {
    if (!same_bits(a.problem.views[i], b.problem.views[i])) return false;
  }
  return true;
}

TEST(Simulate, EveryRigOfTheFolderGivesViewsAndDots) {
  for (const char* name :
       {"rig_26mm_laser.toml", "rig_26mm_laser_0deg.toml", "rig_21mm_stereo.toml", "rig_21mm_stereo_laser.toml"}) {
    const SimulatedRig rig = rig_named(name);
    const Simulation simulation = simulate(rig, {.frames = 20, .seed = 3});
    EXPECT_EQ(simulation.poses.size(), 20u) << name;
    EXPECT_GE(simulation.problem.views.size(), 20u) << name;
    std::size_t dots = 0;
    for (const TargetView& view : simulation.problem.views) dots += view.dots.size();
    EXPECT_EQ(dots > 20 * simulation.problem.views.size() / 2, rig.emitter.has_value()) << name;
  }
}

TEST(Simulate, SameSeedSameBitsAndNeitherNoiseNorMoreFramesNorAWarmerLaserMoveTheBoard) {
  const SimulatedRig rig = rig_named("rig_26mm_laser.toml");
  const Simulation first = simulate(rig, {.frames = 6, .seed = 7});
  EXPECT_TRUE(same_bits(first, simulate(rig, {.frames = 6, .seed = 7})));
  EXPECT_FALSE(same_bits(first, simulate(rig, {.frames = 6, .seed = 8})));
  const Simulation longer = simulate(rig, {.frames = 9, .seed = 7, .corner_sigma_px = 0.5});
  const Simulation warmer = simulate(rig, {.frames = 6, .seed = 7, .warmer_K = 10.0});
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(first.poses[i].rig_from_target.translation, longer.poses[i].rig_from_target.translation);
    EXPECT_EQ(first.poses[i].rig_from_target.translation, warmer.poses[i].rig_from_target.translation);
  }
}

// The exact dot lies on the true beam and on the bent board at once, and the camera sees that very place: three
// formulas that the simulator does not share.
TEST(Simulate, ExactDotsLieOnTheirBeamsAndOnTheBoard) {
  SimulatedRig rig = rig_named("rig_21mm_stereo_laser.toml");
  rig.board.shape = {0.004, -0.003, 0.002};
  const Simulation simulation = simulate(rig, {.frames = 5, .seed = 2, .dot_sigma_px = 0.0});
  const BoardSurface surface(rig.board.target);
  int checked = 0;
  for (const TargetView& view : simulation.exact.views) {
    const RigCamera& camera = simulation.truth.cameras[view.camera];
    const Rigid3 pose = simulation.poses[view.frame].rig_from_target;
    for (const Dot& dot : view.dots) {
      const Line3* beam = nullptr;
      for (const LaserBeam& each : simulation.truth.laser->beams) {
        if (rig.emitter->grid.index(each.row, each.column) == dot.beam) beam = &each.line;
      }
      ASSERT_NE(beam, nullptr);
      const Eigen::Vector3d ray =
          camera.camera_from_rig.rotation.conjugate() * *ray_from_pixel(camera.camera, dot.pixel);
      const Eigen::Vector3d eye = camera.camera_from_rig.inverse().translation;
      // place on the beam nearest to the ray
      const Eigen::Vector3d across_both = ray.cross(beam->direction);
      EXPECT_NEAR((beam->point - eye).dot(across_both.normalized()), 0.0, 1e-10);
      const double along = -(beam->point - eye).cross(ray).dot(across_both) * -1.0 / across_both.squaredNorm();
      const Eigen::Vector3d on_board = pose.inverse() * beam->at(along);
      EXPECT_NEAR(on_board.z(), surface.height(on_board.x(), on_board.y(), rig.board.shape), 1e-9);
      ++checked;
    }
  }
  EXPECT_GT(checked, 100);
}

TEST(Simulate, NoiseHasTheStatedSigma) {
  const SimulatedRig rig = rig_named("rig_26mm_laser.toml");
  const Simulation simulation = simulate(rig, {.frames = 60, .seed = 5, .corner_sigma_px = 0.2, .dot_sigma_px = 0.1});
  double corners = 0.0, dots = 0.0;
  int corner_count = 0, dot_count = 0;
  for (std::size_t v = 0; v < simulation.problem.views.size(); ++v) {
    const TargetView &noisy = simulation.problem.views[v], &exact = simulation.exact.views[v];
    for (std::size_t i = 0; i < noisy.observations.size(); ++i, corner_count += 2) {
      corners += (noisy.observations[i].pixel - exact.observations[i].pixel).squaredNorm();
    }
    for (std::size_t i = 0; i < noisy.dots.size(); ++i, dot_count += 2) {
      dots += (noisy.dots[i].pixel - exact.dots[i].pixel).squaredNorm();
    }
  }
  ASSERT_GT(dot_count, 1000);
  // four standard deviations of a sample's sigma, sigma / sqrt(2 n)
  EXPECT_NEAR(std::sqrt(corners / corner_count), 0.2, 4 * 0.2 / std::sqrt(2.0 * corner_count));
  EXPECT_NEAR(std::sqrt(dots / dot_count), 0.1, 4 * 0.1 / std::sqrt(2.0 * dot_count));
}

// A beam is a line only as far as its hits are spread: what the facts ask of a data set of 60 frames.
TEST(Simulate, SixtyFramesSpreadTheHitsOfNearlyEveryBeamOverDepth) {
  for (const LaserGrid grid : {LaserGrid{11, 11}, LaserGrid{16, 19}}) {
    SimulatedRig rig = rig_named("rig_26mm_laser.toml");
    if (grid.rows != rig.emitter->grid.rows) set_grid(*rig.emitter, grid);
    int poor = 0, fewest = 1000;
    double hits = 0.0, spread = 0.0;
    const Simulation simulation = simulate(rig, {.frames = 60, .seed = 7});
    for (const LaserBeam& beam : simulation.truth.laser->beams) {
      poor += beam.hits < 4 || beam.farthest_hit_m - beam.nearest_hit_m < 0.3;
      fewest = std::min(fewest, beam.hits);
      hits += beam.hits;
      spread += beam.farthest_hit_m - beam.nearest_hit_m;
    }
    const double count = static_cast<double>(simulation.truth.laser->beams.size());
    std::printf("%dx%d beams: %.1f hits each (fewest %d), %.2f m spread, %d poor\n", grid.columns, grid.rows,
                hits / count, fewest, spread / count, poor);
    EXPECT_LE(poor, grid.size() / 20);
  }
}

TEST(Simulate, UnlabelledMissedAndSpuriousDotsAsAskedFor) {
  const SimulatedRig rig = rig_named("rig_26mm_laser.toml");
  const Simulation full = simulate(rig, {.frames = 30, .seed = 4});
  const Simulation poor = simulate(rig, {.frames = 30, .seed = 4, .labelled = false, .missed = 0.1, .spurious = 0.05});
  std::size_t all = 0, kept = 0, spurious = 0;
  bool in_order = true;
  for (const TargetView& view : full.exact.views) all += view.dots.size();
  for (std::size_t v = 0; v < poor.problem.views.size(); ++v) {
    int last = -1;
    for (std::size_t i = 0; i < poor.problem.views[v].dots.size(); ++i) {
      EXPECT_EQ(poor.problem.views[v].dots[i].beam, kUnlabelled);
      const int truth = poor.exact.views[v].dots[i].beam;
      (truth == kUnlabelled ? spurious : kept) += 1;
      in_order &= truth > last;
      last = truth;
    }
  }
  EXPECT_FALSE(in_order);
  const double n = static_cast<double>(all);  // four standard deviations of a binomial
  EXPECT_NEAR(static_cast<double>(kept) / n, 0.9, 4 * std::sqrt(0.09 / n));
  EXPECT_NEAR(static_cast<double>(spurious) / n, 0.045, 4 * std::sqrt(0.05 / n));
}

TEST(Simulate, BrightestBeamIsTheZeroOrder) {
  const SimulatedRig rig = rig_named("rig_26mm_laser.toml");
  const Simulation simulation = simulate(rig, {.frames = 1});
  EXPECT_EQ(simulation.problem.laser->brightest, 5 * 11 + 5);
  EXPECT_TRUE(simulation.problem.laser->missing.empty());
}

TEST(Simulate, RandomRigsOfManySeedsAllWork) {
  std::set<std::string_view> models;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const SimulatedRig rig = random_rig(seed);
    const Simulation simulation = simulate(rig, {.frames = 5, .seed = seed});
    EXPECT_GE(simulation.problem.views.size(), 4u) << seed;
    for (const SimulatedCamera& camera : rig.cameras) models.insert(model_name(camera.camera.model));
  }
  EXPECT_GE(models.size(), 6u);
}

TEST(Simulate, AnImpossiblePoseRangeIsSaid) {
  SimulatedRig rig = rig_named("rig_26mm_laser.toml");
  rig.poses.min_distance_m = rig.poses.max_distance_m = 0.05;
  EXPECT_THROW(simulate(rig, {.frames = 1}), Error);
}

}  // namespace
}  // namespace raybundle::testing
