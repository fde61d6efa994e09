// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "mrcal_solve.hpp"

#ifdef RAYBUNDLE_WITH_MRCAL

extern "C" {
#include <mrcal/mrcal.h>
}

#include <cmath>

#include "raybundle/geometry/rotation.hpp"

namespace raybundle {
namespace {

mrcal_pose_t pose_from(const Rigid3& transform) {
  const Eigen::Vector3d turn = vector_from_rotation(transform.rotation.toRotationMatrix());
  const Eigen::Vector3d& shift = transform.translation;
  mrcal_pose_t pose;
  for (int k = 0; k < 3; ++k) {
    pose.r.xyz[k] = turn[k];
    pose.t.xyz[k] = shift[k];
  }
  return pose;
}

Rigid3 rigid3_from(const mrcal_pose_t& pose) {
  return {Eigen::Quaterniond(rotation_from_vector(Eigen::Vector3d(pose.r.xyz))), Eigen::Vector3d(pose.t.xyz)};
}

Rigid3 target_from(const GridOfPoints& grid) {
  Rigid3 target_from_grid;
  target_from_grid.translation.head<2>() = grid.origin_m;
  return target_from_grid;
}

// The arrays that the optimiser reads and overwrites.
struct Arrays {
  std::vector<double> intrinsics;
  std::vector<mrcal_pose_t> extrinsics, frames;
  std::vector<int> image_sizes;
  std::vector<mrcal_observation_board_t> boards;
  std::vector<mrcal_point3_t> pool;  // a board's nodes, view after view; of negative weight where nothing was seen
  mrcal_calobject_warp_t shape{};

  explicit Arrays(const MrcalProblem& problem) {
    for (const MrcalCamera& camera : problem.cameras) {
      intrinsics.insert(intrinsics.end(), camera.parameters.begin(), camera.parameters.end());
      image_sizes.push_back(camera.size.width);
      image_sizes.push_back(camera.size.height);
    }
    for (std::size_t c = 1; c < problem.cameras.size(); ++c) {
      extrinsics.push_back(pose_from(problem.cameras[c].camera_from_rig));
    }
    for (const Rigid3& pose : problem.rig_from_target) frames.push_back(pose_from(pose * target_from(problem.grid)));
    const std::size_t nodes = static_cast<std::size_t>(problem.grid.rows) * problem.grid.columns;
    for (const MrcalView& view : problem.views) {
      boards.push_back({.icam = {.intrinsics = view.camera, .extrinsics = view.camera - 1}, .iframe = view.pose});
      mrcal_point3_t unseen;
      unseen.x = unseen.y = 0.0;
      unseen.z = -1.0;
      pool.resize(pool.size() + nodes, unseen);
      mrcal_point3_t* first = &pool[pool.size() - nodes];
      for (const MrcalCorner& corner : view.corners) {
        first[corner.node].x = corner.pixel.x();
        first[corner.node].y = corner.pixel.y();
        first[corner.node].z = corner.weight;
      }
    }
  }
};

mrcal_problem_selections_t selections_of(const MrcalProblem& problem, const mrcal_lensmodel_t& model) {
  const bool splined = model.type == MRCAL_LENSMODEL_SPLINED_STEREOGRAPHIC;
  mrcal_problem_selections_t selections{};
  selections.do_optimize_intrinsics_core = !splined;
  selections.do_optimize_intrinsics_distortions = mrcal_lensmodel_num_params(&model) > 4;
  selections.do_optimize_extrinsics = problem.cameras.size() > 1;
  selections.do_optimize_frames = true;
  selections.do_optimize_calobject_warp = problem.with_shape;
  selections.do_apply_regularization = splined;
  return selections;
}

// Of the corners that take part, without their weights.
double rms_px(const MrcalProblem& problem, const std::vector<double>& residuals) {
  const std::size_t nodes = static_cast<std::size_t>(problem.grid.rows) * problem.grid.columns;
  double squares = 0.0;
  std::size_t count = 0;
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    for (const MrcalCorner& corner : problem.views[v].corners) {
      const double* residual = &residuals[2 * (v * nodes + corner.node)];
      squares += (residual[0] * residual[0] + residual[1] * residual[1]) / (corner.weight * corner.weight);
      ++count;
    }
  }
  return std::sqrt(squares / static_cast<double>(std::max<std::size_t>(count, 1)));
}

}  // namespace

bool mrcal_available() { return true; }

std::optional<MrcalAnswer> solve_with_mrcal(const MrcalProblem& problem) {
  mrcal_lensmodel_t model;
  if (!mrcal_lensmodel_from_name(&model, problem.lens_model.c_str())) return std::nullopt;
  Arrays arrays(problem);
  const mrcal_problem_selections_t selections = selections_of(problem, model);
  const mrcal_problem_constants_t constants{.point_min_range = 1e-3, .point_max_range = 1e6};
  const int cameras = static_cast<int>(problem.cameras.size()), extrinsics = cameras - 1;
  const int frames = static_cast<int>(arrays.frames.size()), views = static_cast<int>(arrays.boards.size());
  const int states = mrcal_num_states(cameras, extrinsics, frames, 0, 0, views, selections, &model);
  const int measurements = mrcal_num_measurements(views, 0, problem.grid.columns, problem.grid.rows, cameras,
                                                  extrinsics, frames, 0, 0, selections, &model);
  std::vector<double> state(static_cast<std::size_t>(states)), residuals(static_cast<std::size_t>(measurements));
  const mrcal_stats_t stats = mrcal_optimize(
      state.data(), static_cast<int>(state.size() * sizeof(double)), residuals.data(),
      static_cast<int>(residuals.size() * sizeof(double)), arrays.intrinsics.data(), arrays.extrinsics.data(),
      arrays.frames.data(), nullptr, &arrays.shape, cameras, extrinsics, frames, 0, 0, arrays.boards.data(), nullptr,
      views, 0, arrays.pool.data(), &model, arrays.image_sizes.data(), selections, &constants, problem.grid.spacing_m,
      problem.grid.columns, problem.grid.rows, false, false);
  if (!(stats.rms_reproj_error__pixels >= 0.0)) return std::nullopt;

  MrcalAnswer answer{problem.cameras, {}, rms_px(problem, residuals)};
  const auto size = static_cast<std::size_t>(mrcal_lensmodel_num_params(&model));
  for (std::size_t c = 0; c < answer.cameras.size(); ++c) {
    answer.cameras[c].parameters =
        Eigen::Map<const Eigen::VectorXd>(&arrays.intrinsics[c * size], static_cast<Eigen::Index>(size));
    if (c > 0) answer.cameras[c].camera_from_rig = rigid3_from(arrays.extrinsics[c - 1]);
  }
  for (const mrcal_pose_t& frame : arrays.frames) {
    answer.rig_from_target.push_back(rigid3_from(frame) * target_from(problem.grid).inverse());
  }
  return answer;
}

int mrcal_parameter_count(const std::string& lens_model) {
  mrcal_lensmodel_t model;
  return mrcal_lensmodel_from_name(&model, lens_model.c_str()) ? mrcal_lensmodel_num_params(&model) : 0;
}

SeenRay mrcal_pixel(const std::string& lens_model, const Eigen::VectorXd& parameters, const Eigen::Vector3d& ray) {
  mrcal_lensmodel_t model;
  mrcal_lensmodel_from_name(&model, lens_model.c_str());
  mrcal_point3_t point;
  for (int k = 0; k < 3; ++k) point.xyz[k] = ray[k];
  mrcal_point2_t pixel;
  mrcal_point3_t by_ray[2];
  mrcal_project(&pixel, by_ray, nullptr, &point, 1, &model, parameters.data());
  SeenRay seen{{pixel.x, pixel.y}, {}};
  for (int axis = 0; axis < 2; ++axis) seen.by_ray.row(axis) = Eigen::Map<const Eigen::RowVector3d>(by_ray[axis].xyz);
  return seen;
}

}  // namespace raybundle

#else

namespace raybundle {

bool mrcal_available() { return false; }

std::optional<MrcalAnswer> solve_with_mrcal(const MrcalProblem&) { return std::nullopt; }

int mrcal_parameter_count(const std::string&) { return 0; }

SeenRay mrcal_pixel(const std::string&, const Eigen::VectorXd&, const Eigen::Vector3d&) { return {}; }

}  // namespace raybundle

#endif
