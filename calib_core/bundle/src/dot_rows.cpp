// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "dot_rows.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>

#include "raybundle/geometry/gram.hpp"

namespace raybundle {
namespace {

using Matrix23 = Eigen::Matrix<double, 2, 3>;

// Poses and the board's sags at one evaluation.
struct Place {
  Eigen::Matrix3d rig_from_target, camera_from_rig;  // rotations
  Rigid3 target_from_rig;
  Eigen::Vector3d target_in_rig, rig_in_camera;  // origins
  BoardShape shape;

  explicit Place(const ViewPoint& point)
      : rig_from_target(point.rig_from_target.rotation.toRotationMatrix()),
        camera_from_rig(point.camera_from_rig.rotation.toRotationMatrix()),
        target_from_rig(point.rig_from_target.inverse()),
        target_in_rig(point.rig_from_target.translation),
        rig_in_camera(point.camera_from_rig.translation),
        shape{point.shape[0], point.shape[1], point.shape[2]} {}
};

// Where a beam meets the board. The normal is scaled so that its product with the beam's direction is one.
struct Hit {
  Eigen::Vector3d x_in_rig, normal, shape_basis;
  double distance = 0.0;
};

std::optional<Hit> hit(const BoardSurface& surface, const Place& place, const Line3& beam) {
  const Eigen::Vector3d direction = place.rig_from_target.transpose() * beam.direction;
  const std::optional<Eigen::Vector3d> x =
      surface.crossing({place.target_from_rig * beam.point, direction}, place.shape);
  if (!x) return std::nullopt;
  const Eigen::Vector3d normal = surface.normal(x->x(), x->y(), place.shape);
  const double slope = 1.0 / normal.dot(direction);
  if (!std::isfinite(slope)) return std::nullopt;
  Hit result;
  result.x_in_rig = place.rig_from_target * *x + place.target_in_rig;
  result.normal = slope * (place.rig_from_target * normal);
  result.shape_basis = slope * surface.basis(x->x(), x->y());
  result.distance = beam.direction.dot(result.x_in_rig - beam.point);
  return result;
}

// Square root of the weight ρ' of a dot. Cauchy: ρ(s) = c² log(1 + s / c²); plain least squares for c = 0.
double root_weight(double s, double scale, DotRows& rows) {
  const double c2 = scale * scale;
  const double weight = scale > 0.0 ? 1.0 / (1.0 + s / c2) : 1.0;
  rows.robust_chi2 += scale > 0.0 ? c2 * std::log1p(s / c2) : s;
  return std::sqrt(weight);
}

template <CameraModel M>
bool fill(const ViewDots& view, const ViewPoint& point, const std::vector<Line3>& beams, const DotRowsOptions& options,
          DotRows& rows) {
  constexpr int n = kParameterCount<M>;
  const Place place(point);
  const int shape = options.with_shape ? 3 : 0;
  for (std::size_t i = 0; i < view.dots.size(); ++i) {
    const UsedDot& dot = view.dots[i];
    const Line3& beam = beams[dot.beam];
    const std::optional<Hit> met = hit(view.surface, place, beam);
    if (!met) return false;
    const Eigen::Vector3d turned = place.camera_from_rig * met->x_in_rig;
    Eigen::Vector2d pixel;
    Eigen::Matrix<double, 2, 3, Eigen::RowMajor> wrt_ray;
    Eigen::Matrix<double, 2, n, Eigen::RowMajor> wrt_intrinsics;
    if (!pixel_from_ray<M>(point.intrinsics, turned + place.rig_in_camera, pixel, wrt_ray, wrt_intrinsics)) {
      return false;
    }
    Eigen::Matrix2d whitening;
    whitening << dot.whitening[0], 0.0, dot.whitening[1], dot.whitening[2];
    const Eigen::Vector2d distance = whitening * (pixel - dot.pixel);
    const double root = root_weight(distance.squaredNorm(), options.robust_scale_sigma, rows);
    whitening *= root;

    const Matrix23 wrt_x_in_camera = whitening * wrt_ray;
    const Matrix23 wrt_x_in_rig = wrt_x_in_camera * place.camera_from_rig;
    const Eigen::Matrix<double, 3, 2> basis = across(beam.direction);
    DotMotion& motion = rows.motions[i];
    motion.along_beam = wrt_x_in_rig * beam.direction;
    motion.across = wrt_x_in_rig * basis - motion.along_beam * (met->normal.transpose() * basis);
    motion.distance = met->distance;
    motion.by_board << (met->x_in_rig - place.target_in_rig).cross(met->normal), met->normal;

    auto out = rows.rows.middleRows<2>(static_cast<Eigen::Index>(2 * i));
    out.leftCols<n>() = whitening * wrt_intrinsics;
    out.middleCols<6>(n) = motion.along_beam * motion.by_board.transpose();
    if (shape > 0) out.middleCols<3>(n + 6) = motion.along_beam * met->shape_basis.transpose();
    out.col(n + 6 + shape) = root * distance;
    if (!options.with_camera) continue;
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector3d slope = wrt_x_in_camera.row(axis).transpose();
      out.block<1, 3>(axis, n + 7 + shape) = turned.cross(slope).transpose();
      out.block<1, 3>(axis, n + 10 + shape) = slope.transpose();
    }
  }
  return true;
}

}  // namespace

bool in_use(const CalibrationProblem& problem, const BundleState& state, int view, int dot) {
  if (state.beams.empty() || state.pose_of_view[view] < 0 || state.dot_fates.empty()) return false;
  const int beam = problem.views[view].dots[dot].beam;
  return state.dot_fates[view][dot] == ObservationFate::kUsed && beam != kUnlabelled && state.beams[beam].has_value();
}

std::vector<ViewDots> used_dots(const CalibrationProblem& problem, const BundleState& state) {
  std::vector<ViewDots> views;
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    const TargetView& view = problem.views[v];
    std::vector<UsedDot> dots;
    for (int i = 0; i < static_cast<int>(view.dots.size()); ++i) {
      if (!in_use(problem, state, v, i)) continue;
      const Dot& dot = view.dots[i];
      const Eigen::Matrix2d factor = dot.covariance_px2.llt().matrixL();
      const Eigen::Matrix2d inverse = factor.triangularView<Eigen::Lower>().solve(Eigen::Matrix2d::Identity());
      dots.push_back(
          {.pixel = dot.pixel, .whitening = {inverse(0, 0), inverse(1, 0), inverse(1, 1)}, .beam = dot.beam});
    }
    if (dots.empty()) continue;
    dots.shrink_to_fit();
    views.push_back({.view = v,
                     .camera = view.camera,
                     .target = view.target,
                     .pose = state.pose_of_view[v],
                     .model = state.cameras[view.camera].model,
                     .surface = BoardSurface(problem.targets[view.target]),
                     .dots = std::move(dots)});
  }
  return views;
}

bool fill_dot_rows(const ViewDots& view, const ViewPoint& point, const std::vector<Line3>& beams,
                   const DotRowsOptions& options, DotRows& rows) {
  if (!(point.intrinsics[0] > 0.0) || !(point.intrinsics[1] > 0.0)) return false;
  return with_model(view.model, [&]<CameraModel M>() {
    rows.intrinsics = kParameterCount<M>;
    rows.robust_chi2 = 0.0;
    rows.motions.resize(view.dots.size());
    const auto count = static_cast<Eigen::Index>(2 * view.dots.size());
    const Eigen::Index padded = padded_for_gram(count);
    rows.rows.resize(padded, rows.residual_column(options.with_shape) + 1 + (options.with_camera ? 6 : 0));
    rows.rows.bottomRows(padded - count).setZero();
    return fill<M>(view, point, beams, options, rows);
  });
}

}  // namespace raybundle
