// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/beam_ambiguity.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>

#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

constexpr double kStep_px = 2.0;  // between samples of a curve, which is straight over so little

struct CurveSample {
  int beam = 0;
  Eigen::Vector2d pixel;
  Eigen::Vector2d next;  // pixel of the curve's next sample; its own at the end
  double weight = 0.0;   // inverse depth [1/m] that it stands for
};

/// Pixels of a beam by depth.
class BeamCurve {
 public:
  BeamCurve(const RigCamera& camera, const Line3& line)
      : camera_(camera.camera), line_(camera.camera_from_rig * line) {}

  std::optional<Eigen::Vector2d> at_inverse_depth(double inverse_depth) const {
    if (std::abs(line_.direction.z()) < 1e-6) return std::nullopt;
    const Eigen::Vector3d x = line_.at((1.0 / inverse_depth - line_.point.z()) / line_.direction.z());
    const std::optional<Eigen::Vector2d> pixel = pixel_from_ray(camera_, x);
    return pixel && camera_.size.contains(*pixel) ? pixel : std::nullopt;
  }

 private:
  const Camera& camera_;
  Line3 line_;
};

// Samples of a curve, at most `step_px` apart; equal steps of inverse depth are nearly equal steps in the image.
void sample_curve(const BeamCurve& curve, int beam, const DepthInterval& depths, double step_px,
                  std::vector<CurveSample>& samples) {
  constexpr int kCoarse = 16;
  const double from = 1.0 / depths.farthest_m, to = 1.0 / depths.nearest_m;
  double longest = 0.0;
  for (int i = 0; i < kCoarse; ++i) {
    const auto a = curve.at_inverse_depth(from + (to - from) * i / kCoarse);
    const auto b = curve.at_inverse_depth(from + (to - from) * (i + 1) / kCoarse);
    if (a && b) longest = std::max(longest, (*b - *a).norm());
  }
  const int count = kCoarse * std::max(1, static_cast<int>(std::ceil(longest / step_px)));
  for (int i = 0; i <= count; ++i) {
    const auto pixel = curve.at_inverse_depth(from + (to - from) * i / count);
    if (!pixel) continue;
    const bool follows =
        !samples.empty() && samples.back().beam == beam && (samples.back().pixel - *pixel).norm() < 2.0 * step_px;
    if (follows) samples.back().next = *pixel;
    samples.push_back({beam, *pixel, *pixel, (to - from) / count});
  }
}

double distance_to_segment(const Eigen::Vector2d& pixel, const CurveSample& segment) {
  const Eigen::Vector2d along = segment.next - segment.pixel;
  const double length2 = along.squaredNorm();
  const double share = length2 > 0.0 ? std::clamp(along.dot(pixel - segment.pixel) / length2, 0.0, 1.0) : 0.0;
  return (segment.pixel + share * along - pixel).norm();
}

/// Samples by square cells of the image.
class Cells {
 public:
  Cells(const std::vector<CurveSample>& samples, double width_px) : samples_(samples), width_px_(width_px) {
    for (std::size_t i = 0; i < samples.size(); ++i) cells_[key(samples[i].pixel, 0, 0)].push_back(static_cast<int>(i));
  }

  template <typename Function>
  void for_each_near(const CurveSample& sample, Function&& function) const {
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        const auto cell = cells_.find(key(sample.pixel, dx, dy));
        if (cell == cells_.end()) continue;
        for (int i : cell->second) function(samples_[i]);
      }
    }
  }

 private:
  long key(const Eigen::Vector2d& pixel, int dx, int dy) const {
    constexpr long kRow = 1L << 32;
    return (static_cast<long>(std::floor(pixel.x() / width_px_)) + dx) * kRow +
           static_cast<long>(std::floor(pixel.y() / width_px_)) + dy;
  }

  const std::vector<CurveSample>& samples_;
  double width_px_;
  std::unordered_map<long, std::vector<int>> cells_;
};

struct BeamLine {
  int beam = 0;
  Line3 line;
};

BeamAmbiguity ambiguity_of(const RigCamera& camera, const std::vector<BeamLine>& beams, double tolerance_px,
                           const DepthInterval& depths) {
  if (!(tolerance_px > 0.0) || !(depths.nearest_m > 0.0) || !(depths.farthest_m > depths.nearest_m)) {
    throw Error(ErrorKind::kBadInput,
                "the tolerance and the depths must be positive, the nearest depth below the farthest");
  }
  std::vector<CurveSample> samples;
  for (const BeamLine& beam : beams) {
    sample_curve(BeamCurve(camera, beam.line), beam.beam, depths, kStep_px, samples);
  }
  const Cells cells(samples, tolerance_px + 2.0 * kStep_px);
  std::map<std::pair<int, int>, double> closest;
  double total = 0.0, single = 0.0;
  for (const CurveSample& sample : samples) {
    bool alone = true;
    cells.for_each_near(sample, [&](const CurveSample& other) {
      if (other.beam == sample.beam) return;
      const double distance = distance_to_segment(sample.pixel, other);
      if (distance > tolerance_px) return;
      alone = false;
      double& least = closest.try_emplace(std::minmax(sample.beam, other.beam), distance).first->second;
      least = std::min(least, distance);
    });
    total += sample.weight;
    if (alone) single += sample.weight;
  }
  BeamAmbiguity ambiguity{.tolerance_px = tolerance_px, .pairs = {}};
  for (const auto& [pair, distance] : closest) ambiguity.pairs.push_back({pair.first, pair.second, distance});
  if (total > 0.0) ambiguity.single_candidate_share = single / total;
  return ambiguity;
}

}  // namespace

BeamAmbiguity beam_ambiguity(const RigCamera& camera, const LaserPattern& pattern, double tolerance_px,
                             const DepthInterval& depths) {
  std::vector<BeamLine> beams;
  for (const LaserBeam& beam : pattern.beams) beams.push_back({pattern.grid.index(beam.row, beam.column), beam.line});
  return ambiguity_of(camera, beams, tolerance_px, depths);
}

TurnedPattern best_turn(const RigCamera& camera, const LaserPattern& pattern, double tolerance_px,
                        const DepthInterval& depths) {
  if (!pattern.grating) {
    throw Error(ErrorKind::kBadInput, "the beams follow no common grating, so turning it cannot be foreseen", "laser");
  }
  TurnedPattern best;
  LaserPattern turned = pattern;
  // 0°, 1°, -1°, 2°, ...: of equals the smallest turn, and none is better than one that leaves no doubt.
  for (int step = 0; step < 90 && best.single_candidate_share < 1.0; ++step) {
    const int degrees = step % 2 == 0 ? -step / 2 : (step + 1) / 2;
    const double turn = degrees * M_PI / 180.0;
    turned.grating->rig_from_projector.rotation = pattern.grating->rig_from_projector.rotation *
                                                  Eigen::Quaterniond(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()));
    std::vector<BeamLine> beams;
    for (const LaserBeam& beam : pattern.beams) {
      const auto line = line_of_model(turned, beam.row, beam.column);
      if (line) beams.push_back({pattern.grid.index(beam.row, beam.column), *line});
    }
    const double share = ambiguity_of(camera, beams, tolerance_px, depths).single_candidate_share;
    if (share > best.single_candidate_share) best = {turn, share};
  }
  return best;
}

}  // namespace raybundle
