// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/beam_ambiguity.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "laser_world.hpp"

namespace raybundle {
namespace {

RigCamera wide_camera() { return {"left", start_camera(*model_named("kannala_brandt"), {640, 480}, 282.0), {}}; }

LaserPattern pattern_turned(double turn_rad, int rows, int columns) {
  LaserPattern pattern{.grid = {.rows = rows, .columns = columns}, .beams = {}, .grating = Grating{}};
  pattern.zero_order_row = 0.5 * (rows - 1);
  pattern.zero_order_column = 0.5 * (columns - 1);
  pattern.grating->rig_from_projector.rotation = Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ());
  pattern.grating->rig_from_projector.translation << 0.06, 0, 0;
  pattern.grating->column_pitch = 1.3 / columns;
  pattern.grating->row_pitch = 1.1 / rows;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const auto line =
          beam_of_order(*pattern.grating, column - pattern.zero_order_column, row - pattern.zero_order_row);
      if (!line) continue;
      LaserBeam& beam = pattern.beams.emplace_back();
      beam.row = row;
      beam.column = column;
      beam.line = *line;
    }
  }
  return pattern;
}

// Rows along the baseline lie on the same epipolar curves; turned, few do.
TEST(BeamAmbiguity, TurningTheGridAgainstTheBaselineTellsBeamsApart) {
  const RigCamera camera = wide_camera();
  const BeamAmbiguity along = beam_ambiguity(camera, pattern_turned(0.0, 11, 11), 1.0);
  const BeamAmbiguity turned = beam_ambiguity(camera, pattern_turned(0.24, 11, 11), 1.0);
  EXPECT_LT(1 - turned.single_candidate_share, (1 - along.single_candidate_share) / 3);
  EXPECT_GT(along.pairs.size(), 5 * turned.pairs.size());
}

TEST(BeamAmbiguity, AgreesWithTryingAllPairsOfPoints) {
  const RigCamera camera = wide_camera();
  const LaserPattern pattern = pattern_turned(0.1, 5, 5);
  const double tolerance = 2.0;
  const BeamAmbiguity found = beam_ambiguity(camera, pattern, tolerance);
  const auto pixels = [&](const LaserBeam& beam) {
    std::vector<Eigen::Vector2d> result;
    for (double inverse = 1 / 1.5; inverse <= 1 / 0.15; inverse += 0.02) {
      const double along = (1 / inverse - beam.line.point.z()) / beam.line.direction.z();
      const auto pixel = pixel_from_ray(camera.camera, beam.line.at(along));
      if (pixel && (pixel->array() > -0.5).all() && pixel->x() < 639.5 && pixel->y() < 479.5) result.push_back(*pixel);
    }
    return result;
  };
  std::vector<std::vector<Eigen::Vector2d>> curves;
  for (const LaserBeam& beam : pattern.beams) curves.push_back(pixels(beam));
  std::size_t pairs = 0;
  for (std::size_t a = 0; a < curves.size(); ++a) {
    for (std::size_t b = a + 1; b < curves.size(); ++b) {
      double least = INFINITY;
      for (const auto& p : curves[a]) {
        for (const auto& q : curves[b]) least = std::min(least, (p - q).norm());
      }
      if (least > tolerance) continue;
      ++pairs;
      const auto same = std::ranges::find_if(found.pairs, [&](const AmbiguousBeams& pair) {
        return pair.first == static_cast<int>(a) && pair.second == static_cast<int>(b);
      });
      ASSERT_NE(same, found.pairs.end()) << a << " and " << b << ", " << least << " px";
      EXPECT_NEAR(same->distance_px, least, 0.25 * tolerance);  // the step between samples
    }
  }
  EXPECT_GT(pairs, 3U);
  EXPECT_LE(found.pairs.size(), pairs + 1);
}

TEST(BeamAmbiguity, BestTurnIsBetterThanNoTurn) {
  const RigCamera camera = wide_camera();
  const LaserPattern pattern = pattern_turned(0.0, 7, 7);
  const TurnedPattern best = best_turn(camera, pattern, 2.0);
  EXPECT_GT(std::abs(best.turn_rad), 0.1);
  EXPECT_GT(best.single_candidate_share, beam_ambiguity(camera, pattern, 2.0).single_candidate_share);
  EXPECT_NEAR(best.single_candidate_share,
              beam_ambiguity(camera, pattern_turned(best.turn_rad, 7, 7), 2.0).single_candidate_share, 1e-12);
}

}  // namespace
}  // namespace raybundle
