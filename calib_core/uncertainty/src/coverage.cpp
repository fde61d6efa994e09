// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/coverage.hpp"

#include <algorithm>
#include <cmath>

#include "raybundle/geometry/quantile.hpp"
#include "raybundle/uncertainty/image_cells.hpp"

namespace raybundle {
namespace {

constexpr double kCoveredShare = 0.25;  // of a ninth of the image, below which it counts as empty

double angle_of_pixel(const Camera& camera, const Eigen::Vector2d& pixel) {
  const auto ray = ray_from_pixel(camera, pixel);
  return ray ? angle_off_axis(*ray) : 0.0;
}

// Ninths are named in the order of reading.
void add_image_cells(const RigCamera& camera, CameraCoverage& coverage) {
  const CornerEvidence& evidence = *camera.evidence;
  const ImageSize size = camera.camera.size;
  struct Ninth {
    std::string name;
    int cells = 0, covered = 0;
  };
  std::vector<Ninth> ninths;
  int covered = 0;
  for (int row = 0; row < evidence.rows; ++row) {
    for (int column = 0; column < evidence.columns; ++column) {
      const std::string name =
          region_in_words(size, middle_of_cell(size, evidence.rows, evidence.columns, row, column));
      auto ninth = std::ranges::find(ninths, name, &Ninth::name);
      if (ninth == ninths.end()) ninth = ninths.insert(ninths.end(), Ninth{name});
      const bool seen = evidence.corners[static_cast<std::size_t>(row) * evidence.columns + column] > 0;
      ++ninth->cells;
      ninth->covered += seen;
      covered += seen;
    }
  }
  coverage.image_share = static_cast<double>(covered) / (evidence.rows * evidence.columns);
  for (const Ninth& ninth : ninths) {
    if (ninth.covered < kCoveredShare * ninth.cells) coverage.empty_regions.push_back(ninth.name);
  }
}

double rayless_share(const Camera& camera) {
  constexpr int kColumns = 48;
  const int rows = rows_of_square_cells(camera.size, kColumns);
  int rayless = 0;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      rayless += !ray_from_pixel(camera, middle_of_cell(camera.size, rows, kColumns, row, column));
    }
  }
  return static_cast<double>(rayless) / (rows * kColumns);
}

// Off the axis, towards the middle of an edge; where the model ends before it, as far as it goes.
double reach_towards(const Camera& camera, const Eigen::Vector2d& edge) {
  constexpr int kSteps = 100;
  const Eigen::Vector2d centre(camera.cx(), camera.cy());
  for (int step = kSteps; step > 0; --step) {
    const auto ray = ray_from_pixel(camera, centre + (edge - centre) * step / kSteps);
    if (ray) return angle_off_axis(*ray);
  }
  return 0.0;
}

double reach(const Camera& camera) {
  const double right = camera.size.width - 1, bottom = camera.size.height - 1;
  double largest = 0.0;
  for (const Eigen::Vector2d& edge : {Eigen::Vector2d(0, camera.cy()), Eigen::Vector2d(right, camera.cy()),
                                      Eigen::Vector2d(camera.cx(), 0), Eigen::Vector2d(camera.cx(), bottom)}) {
    largest = std::max(largest, reach_towards(camera, edge));
  }
  return largest;
}

Eigen::Vector3d centre_of(const Target& target) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const TargetPoint& point : target.points) sum += point.x_in_target;
  return sum / static_cast<double>(target.points.size());
}

}  // namespace

std::string region_in_words(ImageSize size, const Eigen::Vector2d& pixel) {
  const auto third = [](double place, int length) { return std::clamp(int(3.0 * (place + 0.5) / length), 0, 2); };
  const int row = third(pixel.y(), size.height), column = third(pixel.x(), size.width);
  static constexpr const char* kNames[3][3] = {
      {"the top left corner", "the top edge", "the top right corner"},
      {"the left edge", "the middle", "the right edge"},
      {"the bottom left corner", "the bottom edge", "the bottom right corner"}};
  return kNames[row][column];
}

std::string regions_in_words(std::vector<std::string> regions) {
  for (const char* kind : {"corner", "edge"}) {
    const auto of_kind = [&](const std::string& region) { return region.ends_with(kind); };
    if (std::ranges::count_if(regions, of_kind) < 4) continue;
    std::erase_if(regions, of_kind);
    regions.push_back(std::string("all four ") + kind + "s");
  }
  std::string text;
  for (std::size_t i = 0; i < regions.size(); ++i) {
    text += (i == 0 ? "" : i + 1 == regions.size() ? " and " : ", ") + regions[i];
  }
  return text;
}

CameraCoverage held_boards(const CalibrationProblem& problem, const CalibrationResult& result,
                           const RigCamera& camera) {
  CameraCoverage held;
  held.camera = camera.name;
  std::vector<double> distances, tilts;
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    const TargetView& view = problem.views[v];
    if (problem.cameras[view.camera].name != camera.name || result.views[v].pose < 0) continue;
    const Rigid3 camera_from_target = camera.camera_from_rig * result.poses[result.views[v].pose].rig_from_target;
    const Eigen::Vector3d centre = camera_from_target * centre_of(problem.targets[view.target]);
    const Eigen::Vector3d normal = camera_from_target.rotation * Eigen::Vector3d::UnitZ();
    distances.push_back(centre.norm());
    tilts.push_back(std::acos(std::min(1.0, std::abs(normal.dot(centre.normalized())))));
  }
  if (distances.empty()) return held;
  held.nearest_m = quantile(distances, 0.05);
  held.farthest_m = quantile(distances, 0.95);
  held.usual_tilt_rad = median(tilts);
  held.largest_tilt_rad = quantile(tilts, 0.9);
  return held;
}

std::vector<CameraCoverage> coverage(const CalibrationProblem& problem, const CalibrationResult& result) {
  std::vector<CameraCoverage> all;
  for (const RigCamera& camera : result.calibration.cameras) {
    CameraCoverage one = held_boards(problem, result, camera);
    if (camera.evidence) add_image_cells(camera, one);
    one.rayless_share = rayless_share(camera.camera);
    one.reach_rad = reach(camera.camera);
    for (std::size_t v = 0; v < problem.views.size(); ++v) {
      const TargetView& view = problem.views[v];
      if (problem.cameras[view.camera].name != camera.name || result.views[v].pose < 0) continue;
      for (std::size_t i = 0; i < view.observations.size(); ++i) {
        if (result.views[v].fates[i] != ObservationFate::kUsed) continue;
        one.seen_to_rad = std::max(one.seen_to_rad, angle_of_pixel(camera.camera, view.observations[i].pixel));
      }
    }
    all.push_back(one);
  }
  return all;
}

}  // namespace raybundle
