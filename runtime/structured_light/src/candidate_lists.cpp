// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "candidate_lists.hpp"

#include <algorithm>
#include <cmath>

namespace raybundle {
namespace {

// A place on a beam and where it is seen, in the image or beside it; nothing where the lens has no pixel for it.
struct Sight {
  double inverse_depth = 0.0;
  std::optional<Eigen::Vector2d> pixel;
};

// Fills a curve step by step.
struct CurveTracer {
  const Camera& camera;
  const Line3& line;
  double step_px;
  std::vector<CurvePoint> curve = {};

  Sight sight(double inverse_depth) const {
    const double along = (1.0 / inverse_depth - line.point.z()) / line.direction.z();
    return {inverse_depth, pixel_from_ray(camera, line.at(along))};
  }

  void add(const Sight& sight) {
    if (sight.pixel && camera.size.contains(*sight.pixel)) curve.push_back({*sight.pixel, 1.0 / sight.inverse_depth});
  }

  // Whether the image may show more between two sights: they are farther apart than a step, and than the image is away.
  bool leave_a_gap(const Sight& a, const Sight& b) const {
    if (!a.pixel || !b.pixel) return a.pixel || b.pixel;
    const double apart_px = (*a.pixel - *b.pixel).norm();
    const Eigen::Vector2d inside =
        a.pixel->cwiseMax(0.0).cwiseMin(Eigen::Vector2d(camera.size.width - 1.0, camera.size.height - 1.0));
    return apart_px > step_px && (*a.pixel - inside).norm() <= apart_px;
  }

  void add_between(const Sight& a, const Sight& b, int halvings) {
    if (halvings == 0 || !leave_a_gap(a, b)) return;
    const Sight middle = sight(0.5 * (a.inverse_depth + b.inverse_depth));
    add_between(a, middle, halvings - 1);
    add(middle);
    add_between(middle, b, halvings - 1);
  }
};

}  // namespace

std::vector<CurvePoint> beam_curve(const Camera& camera, const Line3& line, const SensorRange& range, double step_px) {
  if (std::abs(line.direction.z()) < 1e-6) return {};
  // Equal steps of inverse depth are nearly equal steps in the image; where it shows them, they are halved.
  constexpr int kCoarse = 32, kMostHalvings = 16;
  const double from = 1.0 / range.farthest_m, to = 1.0 / range.nearest_m;
  CurveTracer tracer{camera, line, step_px};
  Sight last = tracer.sight(from);
  tracer.add(last);
  for (int i = 1; i <= kCoarse; ++i) {
    const Sight next = tracer.sight(from + (to - from) * i / kCoarse);
    tracer.add_between(last, next, kMostHalvings);
    tracer.add(next);
    last = next;
  }
  return tracer.curve;
}

std::span<const std::uint16_t> CandidateLists::at(const Eigen::Vector2d& pixel) const {
  const int u = static_cast<int>(pixel.x() + 0.5) / cell_px, v = static_cast<int>(pixel.y() + 0.5) / cell_px;
  const std::size_t cell = static_cast<std::size_t>(v) * columns + u;
  return {beams.data() + first[cell], first[cell + 1] - first[cell]};
}

CandidateLists candidate_lists(const ImageSize& size, const std::vector<std::vector<CurvePoint>>& curves,
                               double margin_px) {
  CandidateLists lists;
  const int cell = lists.cell_px;
  lists.columns = (size.width + cell - 1) / cell;
  lists.rows = (size.height + cell - 1) / cell;
  std::vector<std::vector<std::uint16_t>> in_cell(static_cast<std::size_t>(lists.columns) * lists.rows);
  const auto cell_of = [cell](double px, int count) {
    return std::clamp(static_cast<int>(std::floor((px + 0.5) / cell)), 0, count - 1);
  };
  for (std::size_t beam = 0; beam < curves.size(); ++beam) {
    for (const CurvePoint& point : curves[beam]) {
      const int right = cell_of(point.pixel.x() + margin_px, lists.columns);
      const int low = cell_of(point.pixel.y() + margin_px, lists.rows);
      for (int v = cell_of(point.pixel.y() - margin_px, lists.rows); v <= low; ++v) {
        for (int u = cell_of(point.pixel.x() - margin_px, lists.columns); u <= right; ++u) {
          auto& list = in_cell[static_cast<std::size_t>(v) * lists.columns + u];
          if (list.empty() || list.back() != beam) list.push_back(static_cast<std::uint16_t>(beam));
        }
      }
    }
  }
  lists.first.push_back(0);
  for (const auto& list : in_cell) {
    lists.beams.insert(lists.beams.end(), list.begin(), list.end());
    lists.first.push_back(static_cast<std::uint32_t>(lists.beams.size()));
  }
  return lists;
}

}  // namespace raybundle
