// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "random_rig.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "synthetic_world.hpp"

namespace raybundle::testing {
namespace {

constexpr double kRadian = M_PI / 180.0;

/// How the boards of one rig are held.
struct Habits {
  Holding holding = Holding::kOrdinary;
  double near_share = 0.0;  ///< of the field that the board's half diagonal fills, at least and at most
  double far_share = 0.0;
  double min_tilt_rad = 0.0;
  double max_tilt_rad = 0.0;
  double min_off_axis_rad = 0.0;  ///< of the board's centre
  double max_off_axis_rad = 0.0;
  double hidden = 0.0;  ///< share of the views of which a part is hidden
};

Holding random_holding(Draw& draw) {
  const double which = draw.uniform(0, 1);
  if (which < 0.50) return Holding::kOrdinary;
  if (which < 0.60) return Holding::kNear;
  if (which < 0.70) return Holding::kFar;
  if (which < 0.80) return Holding::kSteep;
  if (which < 0.90) return Holding::kRim;
  if (which < 0.94) return Holding::kParallel;
  return which < 0.97 ? Holding::kFewViews : Holding::kAlike;
}

Habits random_habits(Draw& draw, double half_field_rad) {
  Habits habits{random_holding(draw), 0.6, 0.2, 0, 50 * kRadian, 0, 0.8 * half_field_rad, draw.chance(0.3) ? 0.5 : 0.0};
  switch (habits.holding) {
    case Holding::kNear:
      habits.near_share = 1.2;
      habits.far_share = 0.6;
      break;
    case Holding::kFar:
      habits.near_share = 0.2;
      habits.far_share = 0.08;
      break;
    case Holding::kSteep:
      habits.min_tilt_rad = 50 * kRadian;
      habits.max_tilt_rad = 72 * kRadian;
      break;
    case Holding::kRim:
      habits.min_off_axis_rad = 0.5 * half_field_rad;
      habits.max_off_axis_rad = 0.95 * half_field_rad;
      break;
    default:
      break;
  }
  return habits;
}

Rigid3 random_camera_from_target(Draw& draw, const Habits& habits, double half_field_rad, const Target& target) {
  const Eigen::Vector3d diagonal = target.points.back().x_in_target - target.points.front().x_in_target;
  const Eigen::Vector3d centre = 0.5 * (target.points.back().x_in_target + target.points.front().x_in_target);
  const double off_axis =
      std::sqrt(draw.uniform(std::pow(habits.min_off_axis_rad, 2), std::pow(habits.max_off_axis_rad, 2)));
  const double azimuth = draw.uniform(0, 2 * M_PI);
  const Eigen::Vector3d ray(std::sin(off_axis) * std::cos(azimuth), std::sin(off_axis) * std::sin(azimuth),
                            std::cos(off_axis));
  const double share = draw.log_uniform(habits.far_share, habits.near_share);
  const double half_board_rad = std::min(share * half_field_rad, 75 * kRadian);
  const double distance = 0.5 * diagonal.norm() / std::tan(half_board_rad);
  const bool parallel = habits.holding == Holding::kParallel;
  const double tilt =
      parallel ? draw.uniform(0, 0.3 * kRadian) : draw.uniform(habits.min_tilt_rad, habits.max_tilt_rad);
  const double tilt_azimuth = draw.uniform(0, 2 * M_PI);
  const Eigen::AngleAxisd tilted(tilt, Eigen::Vector3d(std::cos(tilt_azimuth), std::sin(tilt_azimuth), 0));
  const Eigen::AngleAxisd turned(draw.uniform(-M_PI, M_PI), Eigen::Vector3d::UnitZ());
  Rigid3 pose;
  pose.rotation = Eigen::Quaterniond(tilted * turned);
  if (!parallel) pose.rotation = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), ray) * pose.rotation;
  pose.rotation.normalize();
  pose.translation = distance * ray - pose.rotation * centre;
  return pose;
}

/// Boards that are held alike differ by a hand's tremble.
Rigid3 trembling(Draw& draw, const Rigid3& pose) {
  Eigen::Matrix<double, 6, 1> motion;
  for (int i = 0; i < 6; ++i) motion[i] = draw.normal(0.002);
  return perturbed(pose, motion);
}

/// Whether a pixel sees a ray: where prism terms fold an image over itself it sees another one as well, as no glass
/// does.
bool sees(const Camera& camera, const Eigen::Vector2d& pixel, const Eigen::Vector3d& ray) {
  const auto seen = ray_from_pixel(camera, pixel);
  return seen && seen->dot(ray.normalized()) > 1.0 - 1e-9;
}

/// The corners that a lens shows of a board, exactly where they are.
TargetView exact_view(const Camera& camera, double half_field_rad, const Target& target, const Rigid3& pose) {
  TargetView view;
  for (const TargetPoint& point : target.points) {
    const Eigen::Vector3d x = pose * point.x_in_target;
    if (std::atan2(x.head<2>().norm(), x.z()) > half_field_rad) continue;
    const auto pixel = pixel_from_ray(camera, x);
    if (!pixel || pixel->minCoeff() < 0 || pixel->x() > camera.size.width - 1 || pixel->y() > camera.size.height - 1) {
      continue;
    }
    if (!sees(camera, *pixel, x)) continue;
    view.observations.push_back({*pixel, 1.0, point.id});
  }
  return view;
}

/// Something stands before a part of the board: a half plane of the image.
void hide_part(Draw& draw, TargetView& view) {
  const double azimuth = draw.uniform(0, 2 * M_PI);
  const Eigen::Vector2d direction(std::cos(azimuth), std::sin(azimuth));
  std::ranges::sort(view.observations, {}, [&](const Observation& o) { return direction.dot(o.pixel); });
  view.observations.resize(
      static_cast<std::size_t>(draw.uniform(0.35, 1.0) * static_cast<double>(view.observations.size())));
  std::ranges::sort(view.observations, {}, &Observation::point_id);
}

/// Noise for all, and some corners wrong: nearly right, in the next square, or anywhere.
std::vector<ObservationFate> spoil(Draw& draw, const Camera& camera, double noise_px, double outlier_share,
                                   TargetView& view) {
  std::vector<ObservationFate> fates(view.observations.size(), ObservationFate::kUsed);
  for (std::size_t i = 0; i < view.observations.size(); ++i) {
    Observation& observation = view.observations[i];
    observation.sigma_px = noise_px;
    if (draw.chance(outlier_share)) {
      fates[i] = ObservationFate::kOutlier;
      if (draw.chance(0.25)) {
        observation.pixel << draw.uniform(0, camera.size.width - 1), draw.uniform(0, camera.size.height - 1);
      } else {
        const double azimuth = draw.uniform(0, 2 * M_PI);
        observation.pixel +=
            draw.log_uniform(std::max(5.0, 12 * noise_px), 50) * Eigen::Vector2d(std::cos(azimuth), std::sin(azimuth));
      }
    }
    observation.pixel += Eigen::Vector2d(draw.normal(noise_px), draw.normal(noise_px));
  }
  return fates;
}

Target random_board(Draw& draw) {
  const int columns = draw.integer(5, 14);
  const int rows = draw.integer(4, std::min(columns, 10));
  return grid_target("board", columns, rows, draw.log_uniform(0.01, 0.1));
}

constexpr std::array kHoldingNames{"ordinary", "near", "far", "steep", "rim", "parallel", "few views", "alike"};

}  // namespace

RandomRig random_rig(ModelId model, std::uint64_t seed) {
  Draw draw(0x9E3779B97F4A7C15u * (seed + 1) + static_cast<std::uint64_t>(model.index));
  RandomRig rig;
  double half_field_rad = 0.0;
  const Camera camera = random_camera(model, draw, half_field_rad);
  const Target board = random_board(draw);
  const Habits habits = random_habits(draw, half_field_rad);
  rig.holding = habits.holding;
  rig.noise_px = draw.log_uniform(0.05, 0.5);
  rig.outlier_share = draw.chance(0.25) ? 0.0 : draw.uniform(0, 0.2);
  const int wanted =
      rig.holding == Holding::kFewViews ? draw.integer(3, 4) : static_cast<int>(std::lround(draw.log_uniform(5, 60)));
  rig.problem.cameras.push_back({"camera", model, camera.size, {}, {}});
  rig.problem.targets.push_back(board);
  rig.truth.cameras.push_back(camera);
  rig.truth.camera_from_rig.resize(1);
  rig.truth.shapes.resize(1);
  const Rigid3 held = random_camera_from_target(draw, habits, half_field_rad, board);
  std::size_t corners = 0;
  for (int attempt = 0; attempt < 40 * wanted && static_cast<int>(rig.problem.views.size()) < wanted; ++attempt) {
    const Rigid3 pose = rig.holding == Holding::kAlike ? trembling(draw, held)
                                                       : random_camera_from_target(draw, habits, half_field_rad, board);
    TargetView view = exact_view(camera, half_field_rad, board, pose);
    if (draw.chance(habits.hidden)) hide_part(draw, view);
    if (view.observations.size() < 8) continue;
    const int index = static_cast<int>(rig.problem.views.size());
    view.frame = index;
    rig.truth.fates.push_back(spoil(draw, camera, rig.noise_px, rig.outlier_share, view));
    rig.truth.poses.push_back({index, 0, pose});
    rig.truth.pose_of_view.push_back(index);
    rig.problem.frames.push_back(std::to_string(index));
    corners += view.observations.size();
    rig.problem.views.push_back(std::move(view));
  }
  rig.story = fmt::format(
      "{}x{}, {:.0f} deg, f {:.0f} {:.0f}, board {} points, {} views {}, {} corners, noise {:.2f} px, {:.0f} % wrong",
      camera.size.width, camera.size.height, 2 * half_field_rad / kRadian, camera.fx(), camera.fy(),
      board.points.size(), rig.problem.views.size(), kHoldingNames[static_cast<std::size_t>(rig.holding)], corners,
      rig.noise_px, 100 * rig.outlier_share);
  return rig;
}

}  // namespace raybundle::testing
