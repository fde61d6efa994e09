// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "problem.hpp"
#include "raybundle/geometry/error.hpp"
#include "synthetic_world.hpp"

namespace raybundle::bench {
namespace {

constexpr int kColumns = 14;
constexpr int kRows = 10;
constexpr double kSquare_m = 0.025;
constexpr double kDegree = M_PI / 180;

struct Lens {
  const char* model;
  double field_deg;  // across the width of the image
  std::vector<double> shape;
};

struct Family {
  Lens lens;
  int cameras;
  double spacing_m;
  double yaw_deg;       // of each camera against the one before
  int cameras_a_frame;  // that must see the whole board for the frame to count
  double min_distance_m;
  double max_distance_m;
};

const std::map<std::string, Family>& families() {
  static const Lens kb130{"kannala_brandt", 130, {-0.02, 0.005, -0.003, 0.0004}};
  static const Lens kb150{"kannala_brandt", 150, {-0.02, 0.005, -0.003, 0.0004}};
  static const Lens rational70{"rational", 70, {-0.2, 0.3, 0.001, -0.001, 0.02, 0.1, 0.25, 0.03}};
  static const std::map<std::string, Family> all{
      {"kb130", {kb130, 1, 0, 0, 1, 0.25, 0.6}},
      {"kb150", {kb150, 1, 0, 0, 1, 0.2, 0.5}},
      {"rational70", {rational70, 1, 0, 0, 1, 0.4, 0.9}},
      {"stereo_kb130", {kb130, 2, 0.12, 0, 2, 0.25, 0.6}},
      {"stereo_rational70", {rational70, 2, 0.12, 0, 2, 0.5, 1.0}},
      {"rig4_kb130", {kb130, 4, 0.1, 25, 2, 0.3, 0.7}},
  };
  return all;
}

// The focal length with which the field of view fills the width of the image.
double focal_px(const Lens& lens, ImageSize size) {
  Camera camera = start_camera(*model_named(lens.model), size, 1.0);
  for (std::size_t k = 0; k < lens.shape.size(); ++k) camera.parameters[4 + static_cast<int>(k)] = lens.shape[k];
  const double half = 0.5 * lens.field_deg * kDegree;
  const double radius = pixel_from_ray(camera, {std::sin(half), 0, std::cos(half)}).value().x() - camera.cx();
  return 0.5 * size.width / radius;
}

testing::SyntheticOptions world_options(const Family& family, const ProblemSpec& spec) {
  testing::SyntheticOptions options;
  options.columns = kColumns;
  options.rows = kRows;
  options.square_m = kSquare_m;
  options.seed = spec.seed;
  options.min_points = kColumns * kRows;
  options.min_distance_m = family.min_distance_m;
  options.max_distance_m = family.max_distance_m;
  options.max_tilt_rad = 0.8;
  options.max_off_axis_rad = 0.45 * family.lens.field_deg * kDegree;
  options.shape = {spec.bend_m, -0.5 * spec.bend_m, 0.0};
  options.cameras.resize(static_cast<std::size_t>(family.cameras));
  Rigid3 camera_from_rig;
  for (std::size_t c = 0; c < options.cameras.size(); ++c) {
    testing::SyntheticCamera& camera = options.cameras[c];
    camera.model = family.lens.model;
    camera.shape = family.lens.shape;
    camera.focal_px = focal_px(family.lens, camera.size);
    camera.centre_offset_px = {7.0 - 3.0 * static_cast<double>(c), -5.0 + 4.0 * static_cast<double>(c)};
    camera.aspect = 1.002;
    camera.camera_from_rig = camera_from_rig;
    Rigid3 next_from_camera;
    next_from_camera.rotation = Eigen::AngleAxisd(-family.yaw_deg * kDegree, Eigen::Vector3d::UnitY());
    next_from_camera.translation = next_from_camera.rotation * Eigen::Vector3d(-family.spacing_m, 0, 0);
    camera_from_rig = next_from_camera * camera_from_rig;
  }
  return options;
}

// The first frames that enough cameras see whole, renumbered; frames without noise.
testing::SyntheticWorld whole_frames(const Family& family, const ProblemSpec& spec) {
  testing::SyntheticOptions options = world_options(family, spec);
  for (options.frames = 4 * spec.frames;; options.frames *= 2) {
    const testing::SyntheticWorld all = testing::synthetic_world(options);
    std::vector<int> seen(all.poses.size(), 0);
    for (const int pose : all.pose_of_view) ++seen[static_cast<std::size_t>(pose)];
    if (std::ranges::count_if(seen, [&](int n) { return n >= family.cameras_a_frame; }) < spec.frames) continue;
    testing::SyntheticWorld kept = all;
    kept.poses.clear();
    kept.problem.frames.clear();
    kept.problem.views.clear();
    kept.pose_of_view.clear();
    std::vector<int> number(all.poses.size(), -1);
    for (std::size_t p = 0; p < all.poses.size() && static_cast<int>(kept.poses.size()) < spec.frames; ++p) {
      if (seen[p] < family.cameras_a_frame) continue;
      number[p] = static_cast<int>(kept.poses.size());
      kept.problem.frames.push_back(std::to_string(number[p]));
      kept.poses.push_back({number[p], 0, all.poses[p].rig_from_target});
    }
    for (std::size_t v = 0; v < all.problem.views.size(); ++v) {
      const int frame = number[static_cast<std::size_t>(all.pose_of_view[v])];
      if (frame < 0) continue;
      kept.problem.views.push_back(all.problem.views[v]);
      kept.problem.views.back().frame = frame;
      kept.pose_of_view.push_back(frame);
    }
    return kept;
  }
}

// Every 32nd pixel that lies within 48 px of a corner: the image as far as the boards covered it.
std::vector<GridPoint> covered_grid(const testing::SyntheticWorld& world, int camera) {
  constexpr int kStep_px = 32;
  constexpr double kReach_px = 48;
  std::vector<GridPoint> grid;
  const ImageSize size = world.cameras[static_cast<std::size_t>(camera)].size;
  for (int v = kStep_px / 2; v < size.height; v += kStep_px) {
    for (int u = kStep_px / 2; u < size.width; u += kStep_px) {
      const Eigen::Vector2d pixel(u, v);
      const bool covered = std::ranges::any_of(world.problem.views, [&](const TargetView& view) {
        return view.camera == camera && std::ranges::any_of(view.observations, [&](const Observation& observation) {
                 return (observation.pixel - pixel).norm() < kReach_px;
               });
      });
      const auto ray = covered ? ray_from_pixel(world.cameras[static_cast<std::size_t>(camera)], pixel) : std::nullopt;
      if (ray) grid.push_back({*ray, pixel});
    }
  }
  return grid;
}

}  // namespace

std::vector<std::string> problem_families() {
  std::vector<std::string> names;
  for (const auto& [name, family] : families()) names.push_back(name);
  return names;
}

PeerProblem exact_problem(const ProblemSpec& spec) {
  const auto found = families().find(spec.family);
  if (found == families().end()) {
    std::string names;
    for (const std::string& name : problem_families()) names += " " + name;
    throw Error(ErrorKind::kBadInput, "there is no problem family " + spec.family + "; there are:" + names);
  }
  const testing::SyntheticWorld world = whole_frames(found->second, spec);
  PeerProblem made;
  made.family = spec.family;
  made.columns = kColumns;
  made.rows = kRows;
  made.square_m = kSquare_m;
  made.problem = world.problem;
  made.truth = {world.cameras, world.camera_from_rig, world.poses, world.shapes, world.pose_of_view, {}};
  mark_projectable(made.problem, made.truth);
  for (int c = 0; c < static_cast<int>(world.cameras.size()); ++c) made.grid.push_back(covered_grid(world, c));
  return made;
}

// std::normal_distribution differs between standard libraries, so Box and Muller.
PeerProblem with_noise(PeerProblem made, const ProblemSpec& spec) {
  std::mt19937_64 engine(7919u * spec.noise_seed + 13u * spec.seed);
  const auto uniform = [&] { return std::generate_canonical<double, 53>(engine); };
  const auto normal = [&] { return std::sqrt(-2 * std::log(1 - uniform())) * std::cos(2 * M_PI * uniform()); };
  for (std::size_t v = 0; v < made.problem.views.size(); ++v) {
    for (std::size_t i = 0; i < made.problem.views[v].observations.size(); ++i) {
      Observation& observation = made.problem.views[v].observations[i];
      observation.sigma_px = spec.noise_px;
      const double du = normal(), dv = normal();
      observation.pixel += spec.noise_px * Eigen::Vector2d(du, dv);
      if (uniform() >= spec.outlier_fraction) continue;
      const double azimuth = 2 * M_PI * uniform(), far_px = 5 + 45 * uniform();
      observation.pixel += far_px * Eigen::Vector2d(std::cos(azimuth), std::sin(azimuth));
      made.truth.fates[v][i] = ObservationFate::kOutlier;
    }
  }
  return made;
}

PeerProblem make_problem(const ProblemSpec& spec) { return with_noise(exact_problem(spec), spec); }

}  // namespace raybundle::bench
