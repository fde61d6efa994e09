// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/bundle/view_block.hpp"

#include <gtest/gtest.h>

#include "bundle_worlds.hpp"
#include "model_test_types.hpp"

namespace raybundle::testing {
namespace {

// One view of a bent board through each model, with a camera away from the rig's origin and residuals of a few pixels.
template <typename M>
class ViewBlockLaw : public ::testing::Test {
 protected:
  ViewBlockLaw() {
    SyntheticOptions options;
    options.cameras[0].model = std::string(M::kName);
    options.cameras[0].focal_px = 300;
    options.frames = 8;
    options.max_off_axis_rad = 0.4;
    options.noise_px = 2.0;
    options.shape = {0.002, -0.001, 0.0015};
    world_ = synthetic_world(options);
    state_ = true_state(world_);
    view_ = used_views(world_.problem, state_).at(0);
    const Rigid3 camera_from_rig = rig_camera("pinhole", 0.7, 0.3).camera_from_rig;
    intrinsics_ = state_.cameras[0].parameters;
    point_ = {intrinsics_.data(), camera_from_rig, camera_from_rig.inverse() * state_.poses[view_.pose].rig_from_target,
              Eigen::Vector3d(0.002, -0.001, 0.0015)};
  }

  Eigen::VectorXd residual_at(const ViewPoint& point) const {
    ViewBlock block;
    EXPECT_TRUE(linearize_view(view_, point, {}, block));
    return block.residual;
  }

  // Central differences over a parameter's change.
  template <typename Moved>
  void expect_columns(const ViewBlock::Rows& jacobian, double step, const Moved& moved) const {
    for (int k = 0; k < jacobian.cols(); ++k) {
      const Eigen::VectorXd numeric = (residual_at(moved(k, step)) - residual_at(moved(k, -step))) / (2 * step);
      // Truncation and rounding of the difference are both near 1e-8 of the column's size at these steps.
      EXPECT_LE((jacobian.col(k) - numeric).cwiseAbs().maxCoeff(), 1e-6 * (1.0 + numeric.cwiseAbs().maxCoeff()))
          << "column " << k;
    }
  }

  static Rigid3 along(const Rigid3& pose, int k, double step) {
    return perturbed(pose, step * Eigen::Matrix<double, 6, 1>::Unit(k));
  }

  SyntheticWorld world_;
  BundleState state_;
  ViewData view_;
  Eigen::VectorXd intrinsics_;
  ViewPoint point_;
};
TYPED_TEST_SUITE(ViewBlockLaw, AsTestTypes<Models>::Type);

TYPED_TEST(ViewBlockLaw, AnalyticJacobiansAreTheNumericOnes) {
  ViewBlock block;
  ASSERT_TRUE(linearize_view(this->view_, this->point_, {.with_shape = true}, block));
  Eigen::VectorXd changed;
  this->expect_columns(block.wrt_intrinsics, 1e-6, [&](int k, double step) {
    changed = this->intrinsics_;
    changed[k] += step;
    ViewPoint point = this->point_;
    point.intrinsics = changed.data();
    return point;
  });
  this->expect_columns(block.wrt_camera_from_rig, 1e-6, [&](int k, double step) {
    ViewPoint point = this->point_;
    point.camera_from_rig = this->along(point.camera_from_rig, k, step);
    return point;
  });
  this->expect_columns(block.wrt_rig_from_target, 1e-6, [&](int k, double step) {
    ViewPoint point = this->point_;
    point.rig_from_target = this->along(point.rig_from_target, k, step);
    return point;
  });
  this->expect_columns(block.wrt_shape, 1e-6, [&](int k, double step) {
    ViewPoint point = this->point_;
    point.shape[k] += step;
    return point;
  });
}

// Products are those of the rows; without the lens's columns the others stay as they are, to the bit.
TYPED_TEST(ViewBlockLaw, ProductsAreThoseOfTheRows) {
  ViewBlock block;
  ASSERT_TRUE(linearize_view(this->view_, this->point_, {.with_shape = true}, block));
  const Eigen::Index lens = block.wrt_intrinsics.cols();
  Eigen::MatrixXd rows(block.residual.size(), lens + 6 + 3 + 1 + 6);
  rows << block.wrt_intrinsics, block.wrt_rig_from_target, block.wrt_shape, block.residual, block.wrt_camera_from_rig;
  const Eigen::MatrixXd expected = rows.transpose() * rows;
  Eigen::MatrixXd products, without_lens;
  ASSERT_TRUE(multiply_view(this->view_, this->point_, {.with_shape = true}, products));
  ASSERT_TRUE(multiply_view(this->view_, this->point_, {.with_shape = true, .lens_fixed = true}, without_lens));
  // Sums of some hundred terms, rounded in another order.
  const Eigen::VectorXd sizes = expected.diagonal().cwiseSqrt();
  EXPECT_LE(((products - expected).array() / (sizes * sizes.transpose()).array()).abs().maxCoeff(), 1e-12);
  EXPECT_EQ(without_lens, products.bottomRightCorner(expected.rows() - lens, expected.cols() - lens));
}

// The robust cost is the sum of the loss over the corners, by definition of BundleOptions::robust_scale_sigma.
TYPED_TEST(ViewBlockLaw, RobustCostIsTheLossOfEachCorner) {
  const Eigen::VectorXd plain = this->residual_at(this->point_);
  const double c2 = 1.5 * 1.5;
  double expected = 0.0;
  for (int i = 0; i < this->view_.pixel.rows(); ++i) {
    expected += c2 * std::log1p(plain.segment<2>(2 * i).squaredNorm() / c2);
  }
  ViewBlock block;
  ASSERT_TRUE(linearize_view(this->view_, this->point_, {.robust_scale_sigma = 1.5}, block));
  EXPECT_NEAR(block.residual.squaredNorm(), expected, 1e-12 * expected);
}

}  // namespace
}  // namespace raybundle::testing
