// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/synthetic/emitter.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "raybundle/synthetic/rig.hpp"

namespace raybundle::testing {
namespace {

constexpr double kDegree = M_PI / 180.0;

Emitter paper_emitter() { return *read_rig(RAYBUNDLE_SOURCE_DIR "/datasets/rigs/rig_26mm_laser.toml").emitter; }

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

TEST(Emitter, BareGratingHasCosinesLinearInTheOrdersAndOneApex) {
  Emitter emitter;
  emitter.grid = {5, 7};
  emitter.zero_order_row = 2;
  emitter.zero_order_column = 3;
  emitter.column_period_m = emitter.row_period_m = 5e-6;
  for (const EmittedBeam& beam : beams_of(emitter)) {
    EXPECT_NEAR(beam.line.direction.x(), 830e-9 / 5e-6 * (beam.column - 3), 1e-15);
    EXPECT_NEAR(beam.line.direction.y(), 830e-9 / 5e-6 * (beam.row - 2), 1e-15);
    EXPECT_NEAR(beam.line.direction.norm(), 1.0, 1e-15);
    EXPECT_EQ(beam.line.point, Eigen::Vector3d::Zero());
  }
}

// The lensmaker's equation: a paraxial ray from the grating leaves as if from the lens's image of the grating.
TEST(Emitter, LensMeetsItsFocalLengthOnTheAxis) {
  for (const bool inside : {true, false}) {
    Emitter emitter;
    emitter.wavelength_m = emitter.column_period_m = emitter.row_period_m = 1.0;  // orders are direction cosines
    emitter.lens = SpreadingLens{0.009 * 0.517, 1.517, 0.012, 1e-7, inside, Eigen::Vector2d::Zero()};
    const auto ray = ray_of_order(emitter, 1e-4, 0.0);
    ASSERT_TRUE(ray);
    const double slope = ray->direction.x() / ray->direction.z();
    EXPECT_NEAR(slope, 1e-4 * (1.0 + 0.012 / 0.009), 1e-8);  // 1 + distance / focal length
    const double apex = ray->point.z() - ray->point.x() / slope;
    EXPECT_NEAR(apex, 0.012 - 1.0 / (1.0 / 0.012 + 1.0 / 0.009), 1e-6);
  }
}

// Fermat: a light path between two points is stationary, so moving the crossing points changes its length to second
// order only. This checks Snell's law without its formula.
TEST(Emitter, PathsThroughTheLensAreStationary) {
  Emitter emitter = paper_emitter();
  SpreadingLens lens = *emitter.lens;
  lens.offset_m.setZero();
  emitter.lens = lens;
  emitter.lattice_turn_rad = 0.0;
  const auto ray = ray_of_order(emitter, 4.0, 0.0);
  ASSERT_TRUE(ray);
  const Eigen::Vector3d end = ray->at(0.5);
  const double front_centre = lens.distance_m - lens.radius_m, back = lens.distance_m + lens.thickness_m;
  const auto length = [&](double x_front, double x_back) {
    const Eigen::Vector3d front(x_front, 0,
                                front_centre + std::sqrt(lens.radius_m * lens.radius_m - x_front * x_front));
    const Eigen::Vector3d behind(x_back, 0, back);
    return front.norm() + lens.index * (behind - front).norm() + (end - behind).norm();
  };
  // the only stationary place along x_back = the ray's own, for the x_front that makes it stationary there
  double x_front = 0.002;
  for (int i = 0; i < 100; ++i) {  // the best x_front by parabolas
    const double h = 1e-6, x_back = ray->point.x();
    const double slope = (length(x_front + h, x_back) - length(x_front - h, x_back)) / (2 * h);
    const double curvature =
        (length(x_front + h, x_back) - 2 * length(x_front, x_back) + length(x_front - h, x_back)) / (h * h);
    x_front -= slope / curvature;
  }
  const double h = 1e-6;
  EXPECT_NEAR((length(x_front, ray->point.x() + h) - length(x_front, ray->point.x() - h)) / (2 * h), 0.0, 1e-7);
}

TEST(Emitter, FillsItsFieldAndTheBeamsShareNoApex) {
  Emitter emitter = paper_emitter();
  emitter.lens->offset_m.setZero();
  set_periods_from_field(emitter, {90 * kDegree, 70 * kDegree});
  EXPECT_NEAR(angle_between(ray_of_order(emitter, -5, 0)->direction, ray_of_order(emitter, 5, 0)->direction),
              90 * kDegree, 1e-9);
  EXPECT_NEAR(angle_between(ray_of_order(emitter, 0, -5)->direction, ray_of_order(emitter, 0, 5)->direction),
              70 * kDegree, 1e-9);
  const auto apex = [&](double m) {
    const Line3 ray = *ray_of_order(emitter, m, m);
    return ray.point.z() - ray.point.head<2>().norm() / ray.direction.head<2>().norm() * ray.direction.z();
  };
  EXPECT_GT(std::abs(apex(5) - apex(1)), 2e-3);
  EXPECT_LT(std::abs(apex(5) - apex(1)), 5e-3);
}

TEST(Emitter, WarmthScalesTheCosinesOnTheGrating) {
  const Emitter emitter = paper_emitter();
  const Emitter warm = warmer(emitter, 10.0);
  EXPECT_NEAR(warm.wavelength_m / emitter.wavelength_m, 1 + 2.8e-9 / 830e-9, 1e-12);
  const Line3 scaled = *ray_of_order(emitter, 5 * (1 + 2.8 / 830), 3 * (1 + 2.8 / 830));
  EXPECT_LT(angle_between(scaled.direction, ray_of_order(warm, 5, 3)->direction), 1e-12);
}

TEST(Emitter, GridsOfOtherCountsFillTheSameField) {
  const Emitter eleven = paper_emitter();
  Emitter wide = eleven;
  set_grid(wide, {16, 19});
  EXPECT_EQ(beams_of(wide).size(), 304u);
  EXPECT_LT(angle_between(ray_of_order(wide, 9, 7.5)->direction, ray_of_order(eleven, 5, 5)->direction), 1e-12);
}

TEST(Emitter, LeavesOutMissingBeamsAndKeepsAStrayZeroOrder) {
  Emitter emitter = paper_emitter();
  emitter.missing = {{3, 4}};
  EXPECT_EQ(beams_of(emitter).size(), 120u);
  set_grid(emitter, {16, 19});
  emitter.zero_order_power = 0.5;
  const std::vector<EmittedBeam> beams = beams_of(emitter);
  ASSERT_EQ(beams.size(), 305u);
  EXPECT_FALSE(beams.back().labelled());
  EXPECT_NEAR(beams.back().power_W, 0.5 * emitter.beam_power_W, 1e-18);
}

// Parameters of a Grating in a row, for the fit below: a small turn, the origin, pitches, skew, k1, k2, shift.
Grating grating_from(const Eigen::VectorXd& p, const Rigid3& start) {
  Grating grating;
  grating.rig_from_projector = perturbed(start, p.head<6>());
  grating.column_pitch = p[6];
  grating.row_pitch = p[7];
  grating.skew_rad = p[8];
  grating.k1 = p[9];
  grating.k2 = p[10];
  grating.shift_m = p[11];
  return grating;
}

// How well the closed form, which a calibration fits, follows the traced beams: distances of its beams from points on
// the true ones at 0.3 to 1.3 m, as angles. Gauss-Newton with a numeric Jacobian.
double rms_of_best_grating_mrad(const Emitter& emitter) {
  const std::vector<EmittedBeam> beams = beams_of(emitter);
  Rigid3 start = emitter.rig_from_emitter;
  start.rotation = start.rotation * Eigen::AngleAxisd(emitter.lattice_turn_rad, Eigen::Vector3d::UnitZ());
  static constexpr double kDistances[] = {0.3, 0.6, 1.0, 1.3};
  const auto residuals = [&](const Eigen::VectorXd& p) {
    const Grating grating = grating_from(p, start);
    Eigen::VectorXd r(12 * static_cast<Eigen::Index>(beams.size()));
    Eigen::Index at = 0;
    for (const EmittedBeam& beam : beams) {
      const Line3 line =
          *beam_of_order(grating, beam.column - emitter.zero_order_column, beam.row - emitter.zero_order_row);
      for (const double distance : kDistances) {
        r.segment<3>(at) = line.direction.cross(beam.line.at(distance) - line.point) / distance;
        at += 3;
      }
    }
    return r;
  };
  Eigen::VectorXd p = Eigen::VectorXd::Zero(12);
  p[6] = 2.2 * emitter.wavelength_m / emitter.column_period_m;
  p[7] = 2.2 * emitter.wavelength_m / emitter.row_period_m;
  for (int step = 0; step < 50; ++step) {
    const Eigen::VectorXd r = residuals(p);
    Eigen::MatrixXd jacobian(r.size(), 12);
    for (int k = 0; k < 12; ++k) {
      Eigen::VectorXd moved = p;
      moved[k] += 1e-7;
      jacobian.col(k) = (residuals(moved) - r) / 1e-7;
    }
    p -= jacobian.colPivHouseholderQr().solve(r);
  }
  return 1e3 * std::sqrt(residuals(p).squaredNorm() / (4.0 * static_cast<double>(beams.size())));
}

TEST(Emitter, ClosedFormGratingFollowsItOnlyRoughly) {
  const Emitter emitter = paper_emitter();
  Emitter centred = emitter;
  centred.lens->offset_m.setZero();
  const double rms = rms_of_best_grating_mrad(emitter), centred_rms = rms_of_best_grating_mrad(centred);
  std::printf("best shared grating leaves %.2f mrad, %.2f mrad with a centred lens\n", rms, centred_rms);
  RecordProperty("rms_mrad", std::to_string(rms));
  EXPECT_LT(rms, 1.0);          // it is a start value, a label map and an outlier test ...
  EXPECT_GT(rms, 0.5);          // ... but no model: 1 mrad at a gap of 6 cm is 17 mm at 1 m
  EXPECT_LT(centred_rms, 0.2);  // what the two radial terms leave
}

}  // namespace
}  // namespace raybundle::testing
