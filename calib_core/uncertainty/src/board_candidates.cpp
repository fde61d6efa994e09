// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "board_candidates.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>

#include "raybundle/uncertainty/image_cells.hpp"

namespace raybundle {
namespace {

constexpr int kColumns = 5;         // places of the board's centre across the image
constexpr double kTilt = M_PI / 4;  // as far as detectors are sure to follow
constexpr double kSeenShare = 0.5;  // of the board's points
constexpr double kWider = 1.4;      // than the distances there are, when they are all alike
constexpr double kAlike = 1.5;

struct Tilt {
  Eigen::Vector3d axis;  // in the board's own axes; zero: none
  const char* text;
};

// A positive turn about y brings x > 0, the right side, towards the camera.
const Tilt kTilts[] = {{{0, 0, 0}, "facing the camera"},
                       {{0, 1, 0}, "its right side tilted by 45° towards the camera"},
                       {{0, -1, 0}, "its left side tilted by 45° towards the camera"},
                       {{-1, 0, 0}, "its lower side tilted by 45° towards the camera"},
                       {{1, 0, 0}, "its upper side tilted by 45° towards the camera"}};

std::vector<double> distances(const CameraCoverage& held) {
  const bool alike = held.farthest_m < kAlike * held.nearest_m;
  const double nearest = held.nearest_m / (alike ? kWider : 1.0), farthest = held.farthest_m * (alike ? kWider : 1.0);
  return {nearest, std::sqrt(nearest * farthest), farthest};
}

Eigen::AlignedBox3d box_of(const Target& target) {
  Eigen::AlignedBox3d box;
  for (const TargetPoint& point : target.points) box.extend(point.x_in_target);
  return box;
}

// The board upright before the camera, its centre on a ray, then tilted about its centre.
Rigid3 camera_from_board(const Eigen::Vector3d& ray, double distance_m, const Tilt& tilt,
                         const Eigen::Vector3d& centre_in_target) {
  Eigen::Matrix3d facing;
  facing.col(2) = ray;
  facing.col(0) = (Eigen::Vector3d::UnitX() - ray.x() * ray).normalized();
  facing.col(1) = facing.col(2).cross(facing.col(0));
  Eigen::Quaterniond rotation(facing);
  if (!tilt.axis.isZero()) rotation = rotation * Eigen::Quaterniond(Eigen::AngleAxisd(kTilt, tilt.axis));
  return {rotation.normalized(), distance_m * ray - rotation * centre_in_target};
}

}  // namespace

std::vector<BoardCandidate> board_candidates(const Calibration& calibration, int camera, int target,
                                             const ImaginedBoard& imagined, const CameraCoverage& held) {
  const RigCamera& lens = calibration.cameras[camera];
  const Target& board = calibration.targets[target].target;
  const Eigen::Vector3d centre = box_of(board).center();
  const ImageSize size = lens.camera.size;
  const int rows = rows_of_square_cells(size, kColumns);
  const std::string name = calibration.targets.size() == 1 ? "the board" : board.name;
  std::vector<BoardCandidate> candidates;
  for (int cell = 0; cell < rows * kColumns; ++cell) {
    const Eigen::Vector2d pixel = middle_of_cell(size, rows, kColumns, cell / kColumns, cell % kColumns);
    const auto ray = ray_from_pixel(lens.camera, pixel);
    if (!ray || std::abs(ray->x()) > 0.999) continue;
    for (const double distance : distances(held)) {
      for (const Tilt& tilt : kTilts) {
        const Rigid3 rig_from_target = lens.camera_from_rig.inverse() * camera_from_board(*ray, distance, tilt, centre);
        const std::size_t points = imagined.seen_by(camera, rig_from_target).size();
        if (static_cast<double>(points) < kSeenShare * static_cast<double>(board.points.size())) continue;
        candidates.push_back({camera, rig_from_target,
                              fmt::format("hold {} at {} of camera {}, {:.2f} m away, {}", name,
                                          region_in_words(size, pixel), lens.name, distance, tilt.text)});
      }
    }
  }
  return candidates;
}

std::vector<Eigen::Vector2d> outline_in_image(const RigCamera& camera, const Target& target,
                                              const Rigid3& rig_from_target) {
  constexpr int kSteps = 8;  // of an edge, which lenses bend
  const Eigen::AlignedBox3d box = box_of(target);
  const Eigen::Vector3d low = box.min(), high = box.max();
  const Eigen::Vector3d corners[] = {low, {high.x(), low.y(), 0}, {high.x(), high.y(), 0}, {low.x(), high.y(), 0}};
  std::vector<Eigen::Vector2d> outline;
  for (int i = 0; i < 4 * kSteps; ++i) {
    const double part = (i % kSteps) / static_cast<double>(kSteps);
    const Eigen::Vector3d x_in_target = (1 - part) * corners[i / kSteps] + part * corners[(i / kSteps + 1) % 4];
    const auto pixel = pixel_from_ray(camera.camera, camera.camera_from_rig * (rig_from_target * x_in_target));
    if (!pixel) return {};
    outline.push_back(*pixel);
  }
  return outline;
}

}  // namespace raybundle
