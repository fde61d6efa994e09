// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "synthetic_world.hpp"

#include <cmath>
#include <optional>
#include <stdexcept>

#include "draw.hpp"
#include "raybundle/geometry/rotation.hpp"

namespace raybundle::testing {
namespace {

Camera make_camera(const SyntheticCamera& spec) {
  const std::optional<ModelId> model = model_named(spec.model);
  if (!model) throw std::invalid_argument("no camera model " + spec.model);
  Camera camera = start_camera(*model, spec.size, spec.focal_px);
  camera.parameters[1] *= spec.aspect;
  camera.parameters.segment<2>(2) += spec.centre_offset_px;
  with_model(*model, [&]<CameraModel M>() {
    for (int k = 0; k < kShapeSize<M>; ++k) {
      camera.parameters[4 + k] = spec.shape.empty() ? M::kExamples[0].shape[k] : spec.shape[k];
    }
  });
  return camera;
}

// A board whose centre lies off_axis from the camera's axis, turned about its own normal and tilted against the ray.
Rigid3 random_camera_from_target(Draw& draw, const SyntheticOptions& options, const Target& target) {
  const double off_axis = options.max_off_axis_rad * std::sqrt(draw.uniform(0, 1));
  const double azimuth = draw.uniform(0, 2 * M_PI);
  const Eigen::Vector3d ray(std::sin(off_axis) * std::cos(azimuth), std::sin(off_axis) * std::sin(azimuth),
                            std::cos(off_axis));
  const Eigen::Quaterniond towards_ray = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), ray);
  const double tilt_azimuth = draw.uniform(0, 2 * M_PI);
  const Eigen::Vector3d tilt_axis(std::cos(tilt_azimuth), std::sin(tilt_azimuth), 0);
  const Eigen::AngleAxisd tilt(options.max_tilt_rad * std::sqrt(draw.uniform(0, 1)), tilt_axis);
  const Eigen::AngleAxisd turn(draw.uniform(-M_PI, M_PI), Eigen::Vector3d::UnitZ());
  Rigid3 camera_from_target;
  camera_from_target.rotation = (towards_ray * Eigen::Quaterniond(tilt * turn)).normalized();
  const Eigen::Vector3d centre = 0.5 * (target.points.front().x_in_target + target.points.back().x_in_target);
  const double distance = draw.uniform(options.min_distance_m, options.max_distance_m);
  camera_from_target.translation = distance * ray - camera_from_target.rotation * centre;
  return camera_from_target;
}

}  // namespace

SyntheticOptions stereo_head() {
  SyntheticOptions options;
  options.cameras.resize(2);
  options.cameras[1].camera_from_rig.translation.x() = -0.1;
  return options;
}

Target grid_target(const std::string& name, int columns, int rows, double square_m) {
  Target target;
  target.name = name;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      target.points.push_back({row * columns + column, Eigen::Vector3d(column * square_m, row * square_m, 0)});
    }
  }
  return target;
}

SyntheticWorld synthetic_world(const SyntheticOptions& options) {
  Draw draw(options.seed);
  SyntheticWorld world;
  for (std::size_t i = 0; i < options.cameras.size(); ++i) {
    const Camera camera = make_camera(options.cameras[i]);
    world.cameras.push_back(camera);
    world.camera_from_rig.push_back(options.cameras[i].camera_from_rig);
    world.problem.cameras.push_back({"camera" + std::to_string(i), camera.model, camera.size, {}, {}});
  }
  for (int b = 0; b < options.boards; ++b) {
    world.problem.targets.push_back(
        grid_target("board" + std::to_string(b), options.columns, options.rows, options.square_m));
    world.shapes.push_back(options.shape);
  }
  for (int frame = 0; frame < options.frames; ++frame) {
    world.problem.frames.push_back(std::to_string(frame));
    for (int t = 0; t < options.boards; ++t) {
      const Target& target = world.problem.targets[t];
      const std::vector<Eigen::Vector3d> points = points_on_surface(target, options.shape);
      const std::size_t aimed = static_cast<std::size_t>(frame) % options.cameras.size();
      const Rigid3 rig_from_target =
          world.camera_from_rig[aimed].inverse() * random_camera_from_target(draw, options, target);
      world.poses.push_back({frame, t, rig_from_target});
      for (std::size_t c = 0; c < options.cameras.size(); ++c) {
        const Camera& camera = world.cameras[c];
        const double max_angle =
            with_model(camera.model, []<CameraModel M>() { return M::kExamples[0].half_angle_rad; });
        const double limit = std::min(max_angle, 0.98 * max_angle_rad(camera));
        TargetView view{static_cast<int>(c), frame, t, {}};
        std::vector<bool> outliers;
        for (std::size_t i = 0; i < points.size(); ++i) {
          const Eigen::Vector3d x = world.camera_from_rig[c] * (rig_from_target * points[i]);
          if (std::atan2(x.head<2>().norm(), x.z()) > limit) continue;
          const std::optional<Eigen::Vector2d> exact = pixel_from_ray(camera, x);
          if (!exact || exact->x() < 0 || exact->y() < 0 || exact->x() > camera.size.width - 1 ||
              exact->y() > camera.size.height - 1) {
            continue;
          }
          const double sigma = options.noise_px > 0 ? options.noise_px : 1.0;
          Eigen::Vector2d pixel = *exact + options.noise_px * Eigen::Vector2d(draw.normal(), draw.normal());
          const bool outlier = draw.uniform(0, 1) < options.outlier_fraction;
          if (outlier) pixel += draw.uniform(5, 50) * draw.direction().head<2>().normalized();
          view.observations.push_back({pixel, sigma, target.points[i].id});
          outliers.push_back(outlier);
        }
        if (static_cast<int>(view.observations.size()) < options.min_points) continue;
        world.problem.views.push_back(view);
        world.outliers.push_back(outliers);
        world.pose_of_view.push_back(static_cast<int>(world.poses.size()) - 1);
      }
    }
  }
  return world;
}

}  // namespace raybundle::testing
