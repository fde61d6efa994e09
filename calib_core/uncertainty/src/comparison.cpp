// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/comparison.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "projection_difference.hpp"
#include "raybundle/geometry/error.hpp"
#include "sensitivity.hpp"

namespace raybundle {
namespace {

constexpr double kLeastCosine = 0.1;  // of the angle between a beam's lines in both calibrations

const Covariance& covariance_of(const Calibration& calibration, SigmasFrom from) {
  if (from == SigmasFrom::kCorners) return calibration.covariance;
  if (!calibration.covariance_by_frame) {
    throw Error(
        ErrorKind::kBadInput,
        "a calibration has no covariance by frames, which takes at least ten; take the sigmas from the corners");
  }
  return *calibration.covariance_by_frame;
}

// Of what neither calibration leaves uncertain any difference is too much, but for rounding.
double ratio(double difference, double sigma) {
  constexpr double kRounding = 1e-9;
  if (sigma > 0.0) return std::abs(difference) / sigma;
  return std::abs(difference) > kRounding ? std::numeric_limits<double>::infinity() : std::nan("");
}

void compare_extrinsics(const RigCamera& a, const Covariance& of_a, const RigCamera& b, const Covariance& of_b,
                        std::vector<NormalizedDifference>& differences) {
  const Eigen::Matrix<double, 6, 1> motion = motion_between(a.camera_from_rig, b.camera_from_rig);
  const std::vector<std::string> names = extrinsic_names(a);
  const Eigen::MatrixXd covariance = of_a.block(names) + of_b.block(names);
  for (Eigen::Index i = 0; i < 6; ++i) {
    const double sigma = std::sqrt(covariance(i, i));
    differences.push_back({names[static_cast<std::size_t>(i)], motion[i], sigma, ratio(motion[i], sigma)});
  }
}

// Both beams' motions are told in a's coordinates: b's point lies elsewhere along the line, where the slopes have moved
// it by their lever.
NormalizedDifference beam_difference(const LaserBeam& a, const LaserBeam& b) {
  const Eigen::Vector4d motion = motion_between(a.line, b.line);
  Eigen::Matrix4d in_a = Eigen::Matrix4d::Identity();
  in_a.topRightCorner<2, 2>().diagonal().setConstant(a.line.direction.dot(a.line.point - b.line.point));
  const Eigen::Matrix4d covariance = a.covariance + in_a * b.covariance * in_a.transpose();
  NormalizedDifference result{fmt::format("{},{}", a.row, a.column), motion.head<2>().norm(),
                              std::sqrt(covariance.topLeftCorner<2, 2>().trace()), ratio(motion.norm(), 0.0)};
  const Eigen::LDLT<Eigen::Matrix4d> solver(covariance);
  if (solver.isPositive() && solver.vectorD().minCoeff() > 0.0) {
    result.sigmas = std::sqrt(motion.dot(solver.solve(motion)) / 4.0);
  }
  return result;
}

// Beams that look nearly at right angles to each other, or apart, have no motion between them.
NormalizedDifference turned_beam(const LaserBeam& a, const LaserBeam& b) {
  return {fmt::format("{},{}", a.row, a.column), (a.line.point - b.line.point).norm(), 0.0,
          std::numeric_limits<double>::infinity()};
}

void compare_beams(const LaserPattern& a, const LaserPattern& b, CalibrationComparison& comparison) {
  if (a.grid.rows != b.grid.rows || a.grid.columns != b.grid.columns) {
    comparison.not_compared.push_back("the grids of beams differ in size, so that the beams were not compared");
    return;
  }
  for (const LaserBeam& beam : a.beams) {
    const auto same = std::ranges::find_if(
        b.beams, [&](const LaserBeam& other) { return other.row == beam.row && other.column == beam.column; });
    if (same == b.beams.end()) continue;
    const bool turned = beam.line.direction.dot(same->line.direction) < kLeastCosine;
    comparison.beams.push_back(turned ? turned_beam(beam, *same) : beam_difference(beam, *same));
  }
  const std::size_t both = comparison.beams.size(), most = std::max(a.beams.size(), b.beams.size());
  if (both == a.beams.size() && both == b.beams.size()) return;
  const std::string remark = fmt::format("of {} beams in the one and {} in the other calibration {} are in both",
                                         a.beams.size(), b.beams.size(), both);
  const bool few = static_cast<double>(both) < kLeastShareWithin * static_cast<double>(most);
  (few ? comparison.not_compared : comparison.remarks).push_back(remark);
}

// What only one of two calibrations has.
void tell_lonely(const Calibration& a, const Calibration& b, std::vector<std::string>& lonely) {
  for (const auto& [one, other, which] : {std::tuple(&a, &b, "first"), std::tuple(&b, &a, "second")}) {
    for (const RigCamera& camera : one->cameras) {
      if (std::ranges::find(other->cameras, camera.name, &RigCamera::name) != other->cameras.end()) continue;
      lonely.push_back(fmt::format("camera {} is in the {} calibration only", camera.name, which));
    }
    if (one->laser && !other->laser) lonely.push_back(fmt::format("a laser is in the {} calibration only", which));
  }
}

void refuse_other_sizes(const RigCamera& a, const RigCamera& b) {
  if (a.camera.size == b.camera.size) return;
  throw Error(
      ErrorKind::kBadInput,
      fmt::format("the images of camera {} are {}x{} px in one calibration and {}x{} in the other; compare "
                  "calibrations of the same images",
                  a.name, a.camera.size.width, a.camera.size.height, b.camera.size.width, b.camera.size.height));
}

}  // namespace

double share_within(const ProjectionDifference& difference, double sigmas) {
  int cells = 0, within = 0;
  for (Eigen::Index i = 0; i < difference.u_px.size(); ++i) {
    const double distance = std::hypot(difference.u_px.data()[i], difference.v_px.data()[i]);
    if (!std::isfinite(distance)) continue;
    ++cells;
    within += distance <= sigmas * difference.sigma_px.data()[i];
  }
  const double of_entries = cells > 0 ? static_cast<double>(within) / cells : 1.0;
  return of_entries * (1.0 - difference.lost_share);
}

bool CalibrationComparison::agrees() const { return std::ranges::all_of(projections, &ProjectionDifference::agrees); }

CalibrationComparison compare(const Calibration& a, const Calibration& b, const ComparisonOptions& options) {
  const Covariance& of_a = covariance_of(a, options.sigmas_from);
  const Covariance& of_b = covariance_of(b, options.sigmas_from);
  CalibrationComparison comparison;
  comparison.sigmas_from = options.sigmas_from;
  tell_lonely(a, b, comparison.not_compared);
  const bool same_rig = a.cameras[0].name == b.cameras[0].name;
  if (!same_rig) {
    comparison.not_compared.push_back(fmt::format(
        "the first cameras, whose frames are the rig frames, are {} and {}: extrinsics and beams were not compared",
        a.cameras[0].name, b.cameras[0].name));
  }
  for (const RigCamera& camera : a.cameras) {
    const auto same = std::ranges::find(b.cameras, camera.name, &RigCamera::name);
    if (same == b.cameras.end()) continue;
    refuse_other_sizes(camera, *same);
    if (!camera.evidence || !same->evidence) {
      comparison.remarks.push_back(fmt::format(
          "the {} calibration does not tell where the corners of camera {} were: they are taken from the {}",
          camera.evidence ? "second" : "first", camera.name, camera.evidence ? "first" : "second"));
    }
    for (const double range_m : options.ranges_m) {
      comparison.projections.push_back(projection_difference(camera, of_a, *same, of_b, range_m, options.columns));
    }
    if (same_rig && &camera != &a.cameras[0]) compare_extrinsics(camera, of_a, *same, of_b, comparison.extrinsics);
  }
  if (comparison.projections.empty()) {
    throw Error(ErrorKind::kBadInput, "the calibrations have no camera in common; cameras are matched by name");
  }
  if (same_rig && a.laser && b.laser) compare_beams(*a.laser, *b.laser, comparison);
  return comparison;
}

}  // namespace raybundle
