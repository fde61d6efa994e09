// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "beam_knowledge.hpp"

#include <algorithm>
#include <cmath>

#include "figures.hpp"
#include "raybundle/geometry/quantile.hpp"
#include "raybundle/scene/board_surface.hpp"
#include "raybundle/uncertainty/beam_depth.hpp"
#include "sensitivity.hpp"

namespace raybundle {
namespace {

constexpr double kGrazing = 0.4;  // cosine between beam and normal, below which dots are too long to be measured well

// Of a dot's pixel by the motion of perturbed(beam, .), while the dot stays on the board.
std::optional<Eigen::Matrix<double, 2, 4>> pixel_by_beam(const RigCamera& camera, const Line3& beam,
                                                         const Eigen::Vector3d& x_in_rig,
                                                         const Eigen::Vector3d& normal) {
  const Eigen::Vector3d x_in_camera = camera.camera_from_rig * x_in_rig;
  const std::optional<Eigen::Vector2d> pixel = pixel_from_ray(camera.camera, x_in_camera);
  const std::optional<PixelDerivatives> derivatives = pixel_derivatives(camera.camera, x_in_camera);
  if (!pixel || !derivatives || !camera.camera.size.contains(*pixel)) return std::nullopt;
  Eigen::Matrix<double, 3, 4> by_beam;
  by_beam.leftCols<2>() = across(beam.direction);
  by_beam.rightCols<2>() = beam.direction.dot(x_in_rig - beam.point) * by_beam.leftCols<2>();
  by_beam -= beam.direction * (normal.transpose() * by_beam) / normal.dot(beam.direction);
  return derivatives->by_ray * (camera.camera_from_rig.rotation.toRotationMatrix() * by_beam);
}

}  // namespace

BeamMatrices stated_beams(const Calibration& calibration) {
  BeamMatrices covariances;
  for (const LaserBeam& beam : calibration.laser->beams) covariances.push_back(beam.covariance);
  return covariances;
}

double dot_sigma(const CalibrationProblem& problem, const CalibrationResult& result) {
  std::vector<double> sigmas;
  for (const TargetView& view : problem.views) {
    for (const Dot& dot : view.dots) sigmas.push_back(std::sqrt(0.5 * dot.covariance_px2.trace()));
  }
  if (sigmas.empty() || !result.laser) return 0.0;
  return median(sigmas) * result.laser->sigma_scale;
}

BeamMatrices imagined_dots(const Calibration& calibration, int target, const Rigid3& rig_from_target, double sigma_px) {
  const std::vector<LaserBeam>& beams = calibration.laser->beams;
  const CalibratedTarget& board = calibration.targets[target];
  const BoardSurface surface(board.target);
  const Rigid3 target_from_rig = rig_from_target.inverse();
  BeamMatrices information(beams.size(), Eigen::Matrix4d::Zero());
  for (std::size_t b = 0; b < beams.size(); ++b) {
    const std::optional<Eigen::Vector3d> dot = surface.crossing(target_from_rig * beams[b].line, board.shape);
    if (!dot || !surface.covers(*dot)) continue;
    const Eigen::Vector3d normal =
        rig_from_target.rotation * surface.normal(dot->x(), dot->y(), board.shape).normalized();
    if (std::abs(normal.dot(beams[b].line.direction)) < kGrazing) continue;
    const auto by_beam = pixel_by_beam(calibration.cameras[0], beams[b].line, rig_from_target * *dot, normal);
    if (by_beam) information[b] = by_beam->transpose() * *by_beam / (sigma_px * sigma_px);
  }
  return information;
}

std::vector<double> beam_sigmas(const Calibration& calibration, const BeamMatrices& covariances, double range_m) {
  const std::vector<LaserBeam>& beams = calibration.laser->beams;
  const auto own = [&](std::size_t b, const Eigen::Matrix4d& covariance) {
    return beam_depth(calibration.cameras[0], {}, beams[b].line, covariance, {}, range_m).sigma_m;
  };
  std::vector<double> sigmas;
  for (std::size_t b = 0; b < beams.size(); ++b) {
    const double stated = stated_beam_sigma(beams[b], range_m);
    const double before = own(b, beams[b].covariance);
    const double after = covariances[b] == beams[b].covariance ? before : own(b, covariances[b]);
    if (!std::isfinite(stated) || !(before > 0.0)) continue;
    const double of_cameras2 = std::max(0.0, stated * stated - before * before);
    sigmas.push_back(std::hypot(std::sqrt(of_cameras2), std::min(stated, before) * after / before));
  }
  return sigmas;
}

}  // namespace raybundle
