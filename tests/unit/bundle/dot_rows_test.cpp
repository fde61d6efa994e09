// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "../../../calib_core/bundle/src/dot_rows.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "laser_worlds.hpp"
#include "model_test_types.hpp"

namespace raybundle::testing {
namespace {

const Eigen::Matrix2d kCovariance{{0.04, 0.015}, {0.015, 0.02}};

// The dots of one view of a bent board through each model, with a camera away from the rig's origin and residuals of a
// few pixels.
template <typename M>
class DotRowsLaw : public ::testing::Test {
 protected:
  DotRowsLaw() {
    SyntheticOptions options;
    options.cameras[0].model = std::string(M::kName);
    options.cameras[0].focal_px = 300;
    options.frames = 12;
    options.max_off_axis_rad = 0.4;
    options.shape = {0.004, -0.003, 0.002};
    made_ = laser_world(options, {.grid = {.rows = 7, .columns = 7}, .noise_px = 2.0}, 1);
    for (TargetView& view : made_.world.problem.views) {
      for (Dot& dot : view.dots) dot.covariance_px2 = kCovariance;
    }
    const std::vector<ViewDots> all = used_dots(made_.world.problem, made_.truth);
    view_ = *std::ranges::max_element(all, {}, [](const ViewDots& view) { return view.dots.size(); });
    const Rigid3 camera_from_rig = rig_camera("pinhole", 0.7, 0.3).camera_from_rig;
    const Rigid3 rig_from_camera = camera_from_rig.inverse();
    intrinsics_ = made_.truth.cameras[0].parameters;
    point_ = {intrinsics_.data(), camera_from_rig, rig_from_camera * made_.truth.poses[view_.pose].rig_from_target,
              Eigen::Vector3d(0.004, -0.003, 0.002)};
    for (const auto& line : made_.truth.beams) {
      const Line3 beam = line.value_or(Line3{});
      beams_.push_back(rig_from_camera * beam);
    }
  }

  DotRows rows_at(const ViewPoint& point, const std::vector<Line3>& beams, double robust = 0.0) const {
    DotRows rows;
    EXPECT_TRUE(fill_dot_rows(view_, point, beams,
                              {.with_shape = true, .with_camera = true, .robust_scale_sigma = robust}, rows));
    return rows;
  }
  Eigen::VectorXd residual_at(const ViewPoint& point) const {
    const DotRows rows = rows_at(point, beams_);
    return rows.rows.col(rows.residual_column(true));
  }

  // Central differences over a parameter's change.
  template <typename Moved>
  void expect_columns(const Eigen::MatrixXd& jacobian, const Moved& moved) const {
    const double step = 1e-6;
    for (int k = 0; k < jacobian.cols(); ++k) {
      const Eigen::VectorXd numeric = (moved(k, step) - moved(k, -step)) / (2 * step);
      // Truncation and rounding of the difference are both near 1e-8 of the column's size at these steps.
      EXPECT_LE((jacobian.col(k) - numeric).cwiseAbs().maxCoeff(), 2e-6 * (1.0 + numeric.cwiseAbs().maxCoeff()))
          << "column " << k;
    }
  }

  static Rigid3 along(const Rigid3& pose, int k, double step) {
    return perturbed(pose, step * Eigen::Matrix<double, 6, 1>::Unit(k));
  }

  LaserWorld made_;
  ViewDots view_{.model = {}, .surface = BoardSurface(grid_target("any", 3, 3, 0.1)), .dots = {}};
  Eigen::VectorXd intrinsics_;
  ViewPoint point_;
  std::vector<Line3> beams_;
};
TYPED_TEST_SUITE(DotRowsLaw, AsTestTypes<Models>::Type);

TYPED_TEST(DotRowsLaw, AnalyticJacobiansAreTheNumericOnes) {
  ASSERT_GE(this->view_.dots.size(), 10U);
  const DotRows rows = this->rows_at(this->point_, this->beams_);
  const int n = rows.intrinsics;
  Eigen::VectorXd changed;
  this->expect_columns(rows.rows.leftCols(n), [&](int k, double step) {
    changed = this->intrinsics_;
    changed[k] += step;
    ViewPoint point = this->point_;
    point.intrinsics = changed.data();
    return this->residual_at(point);
  });
  this->expect_columns(rows.rows.middleCols(n, 6), [&](int k, double step) {
    ViewPoint point = this->point_;
    point.rig_from_target = this->along(point.rig_from_target, k, step);
    return this->residual_at(point);
  });
  this->expect_columns(rows.rows.middleCols(n + 6, 3), [&](int k, double step) {
    ViewPoint point = this->point_;
    point.shape[k] += step;
    return this->residual_at(point);
  });
  this->expect_columns(rows.rows.rightCols(6), [&](int k, double step) {
    ViewPoint point = this->point_;
    point.camera_from_rig = this->along(point.camera_from_rig, k, step);
    return this->residual_at(point);
  });
  Eigen::MatrixXd wrt_beam = Eigen::MatrixXd::Zero(rows.rows.rows(), 4);
  for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(this->view_.dots.size()); ++i) {
    const DotMotion& motion = rows.motions[i];
    wrt_beam.block<2, 2>(2 * i, 0) = motion.across;
    wrt_beam.block<2, 2>(2 * i, 2) = motion.distance * motion.across;
    const auto by_board = rows.rows.block<2, 6>(2 * i, n);
    EXPECT_LE((by_board - motion.along_beam * motion.by_board.transpose()).norm(), 1e-12 * by_board.norm());
  }
  this->expect_columns(wrt_beam, [&](int k, double step) {
    std::vector<Line3> moved = this->beams_;
    for (Line3& beam : moved) beam = perturbed(beam, step * Eigen::Vector4d::Unit(k));
    const DotRows there = this->rows_at(this->point_, moved);
    return Eigen::VectorXd(there.rows.col(there.residual_column(true)));
  });
}

// The squared rows are the Mahalanobis distances of what dot_residuals() says.
TYPED_TEST(DotRowsLaw, ResidualsAreWhitenedByTheDotsCovariance) {
  const std::vector<Eigen::Vector2d> residuals =
      dot_residuals(this->made_.world.problem, this->made_.truth, this->view_.view);
  double expected = 0.0, robust = 0.0, of_rows = 0.0;
  const double c2 = 3.0 * 3.0;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    if (this->made_.truth.dot_fates[this->view_.view][i] != ObservationFate::kUsed) continue;
    const double s = residuals[i].dot(kCovariance.llt().solve(residuals[i]));
    expected += s;
    robust += c2 * std::log1p(s / c2);
    of_rows += s / (1.0 + s / c2);  // s ρ'(s)
  }
  const DotRows rows = this->rows_at(this->point_, this->beams_);
  EXPECT_NEAR(rows.rows.col(rows.residual_column(true)).squaredNorm(), expected, 1e-9 * expected);
  EXPECT_NEAR(rows.robust_chi2, expected, 1e-9 * expected);
  const DotRows weighted = this->rows_at(this->point_, this->beams_, 3.0);
  EXPECT_NEAR(weighted.robust_chi2, robust, 1e-9 * robust);
  EXPECT_NEAR(weighted.rows.col(rows.residual_column(true)).squaredNorm(), of_rows, 1e-9 * robust);
}

}  // namespace
}  // namespace raybundle::testing
