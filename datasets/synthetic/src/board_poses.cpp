// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "board_poses.hpp"

#include <algorithm>
#include <cmath>

#include "raybundle/geometry/error.hpp"
#include "raybundle/synthetic/random.hpp"
#include "view_geometry.hpp"

namespace raybundle {
namespace {

constexpr double kNearestPoint_m = 0.08;  // a hand needs that much
constexpr int kAims = 200, kTriesAtAim = 100;
constexpr std::size_t kFewestCorners = 20;  // of a board that is not seen whole

// A line on which the board is put, from a camera through a random place of its image.
std::optional<Line3> line_through_pixel(const SimulatedRig& rig, Random& random) {
  const SimulatedCamera& camera = rig.cameras[random.below(static_cast<int>(rig.cameras.size()))];
  const ImageSize size = camera.camera.size;
  const auto ray =
      ray_from_pixel(camera.camera, {random.uniform(0, size.width - 1), random.uniform(0, size.height - 1)});
  if (!ray || std::atan2(ray->head<2>().norm(), ray->z()) > camera.used_half_angle_rad) return std::nullopt;
  const Rigid3 rig_from_camera = camera.camera_from_rig.inverse();
  return Line3{rig_from_camera.translation, rig_from_camera.rotation * *ray};
}

// Printed side towards the viewer, its x to the viewer's right, then rolled about the line of sight and tilted.
Eigen::Quaterniond held_orientation(const SimulatedRig& rig, const Eigen::Vector3d& sight, Random& random) {
  const PoseRange& range = rig.poses;
  const double azimuth = random.uniform(0, 2 * M_PI);
  const double tilt = range.max_tilt_rad * std::sqrt(random.uniform());
  const double roll = random.uniform(-range.max_roll_rad, range.max_roll_rad);
  const Eigen::Quaterniond towards = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), sight);
  const Eigen::AngleAxisd tilted(tilt, Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), 0));
  const Eigen::AngleAxisd rolled(roll, Eigen::Vector3d::UnitZ());
  // A target whose printed side looks along +z has its y upwards.
  const Eigen::AngleAxisd turned(rig.board.print.front > 0 ? M_PI : 0.0, Eigen::Vector3d::UnitX());
  return (towards * Eigen::Quaterniond(tilted * rolled * turned)).normalized();
}

// A place in front of the rig.
std::optional<Eigen::Vector3d> random_place(const SimulatedRig& rig, const std::vector<EmittedBeam>& beams,
                                            Random& random) {
  const double distance_m = random.uniform(rig.poses.min_distance_m, rig.poses.max_distance_m);
  if (!beams.empty() && random.chance(0.6)) {  // the others fill the cameras' images
    return beams[random.below(static_cast<int>(beams.size()))].line.at(distance_m);
  }
  const auto line = line_through_pixel(rig, random);
  return line ? std::optional(line->at(distance_m)) : std::nullopt;
}

// A board that has a random place of its sheet there.
Rigid3 random_pose_at(const SimulatedRig& rig, const BoardSurface& surface, const Eigen::Vector3d& place,
                      Random& random) {
  const BoardPrint::Box& sheet = rig.board.print.sheet;
  const double x = random.uniform(sheet.low.x(), sheet.high.x()), y = random.uniform(sheet.low.y(), sheet.high.y());
  Rigid3 pose;
  pose.rotation = held_orientation(rig, place.normalized(), random);
  pose.translation = place - pose.rotation * Eigen::Vector3d(x, y, surface.height(x, y, rig.board.shape));
  return pose;
}

// Whether a person could calibrate with it: enough points seen, and the sheet not inside of the rig.
bool usable(const SimulatedRig& rig, const BoardSurface& surface, const Rigid3& pose) {
  const std::vector<Eigen::Vector3d> points = points_on_surface(rig.board.target, rig.board.shape);
  const PlacedBoard placed(rig.board, surface, pose);
  const std::size_t needed = rig.poses.whole_board ? points.size() : std::min(kFewestCorners, points.size());
  for (const Eigen::Vector3d& x : points) {
    if ((pose * x).norm() < kNearestPoint_m) return false;
  }
  return std::ranges::any_of(rig.cameras, [&](const SimulatedCamera& camera) {
    std::size_t seen = 0, tried = 0;
    for (const Eigen::Vector3d& x : points) {
      seen += placed.seen_at(camera, x).has_value();
      if (++tried - seen > points.size() - needed) return false;
    }
    return true;
  });
}

}  // namespace

std::vector<Rigid3> random_board_poses(const SimulatedRig& rig, const BoardSurface& surface,
                                       const std::vector<EmittedBeam>& beams, int frames, std::uint64_t seed) {
  std::vector<Rigid3> poses;
  for (int frame = 0; frame < frames; ++frame) {
    Random random(seed, 2 * static_cast<std::uint64_t>(frame));
    std::optional<Rigid3> pose;
    // Places that hardly ever show the board are given up late: the near and the outermost would be too rare otherwise.
    for (int aim = 0; aim < kAims && !pose; ++aim) {
      const auto place = random_place(rig, beams, random);
      for (int i = 0; place && i < kTriesAtAim && !pose; ++i) {
        pose = random_pose_at(rig, surface, *place, random);
        if (!usable(rig, surface, *pose)) pose.reset();
      }
    }
    if (!pose) {
      throw Error(ErrorKind::kNotEnoughData,
                  std::to_string(kAims * kTriesAtAim) + " poses were tried and in none of them does a camera see " +
                      (rig.poses.whole_board ? "the whole board" : "enough of the board") +
                      "; move [poses].distance_m, or take a smaller board or whole_board = false");
    }
    poses.push_back(*pose);
  }
  return poses;
}

}  // namespace raybundle
