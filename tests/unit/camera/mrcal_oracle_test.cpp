// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// mrcal as a second opinion on the models that it has. It is linked by this test only, where it is installed.
#include <gtest/gtest.h>

#if __has_include(<mrcal/mrcal.h>)

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpragmas"
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
extern "C" {
#include <mrcal/mrcal.h>
}
#pragma GCC diagnostic pop

#include <Eigen/Geometry>

#include "oracle_support.hpp"

namespace raybundle {
namespace {

template <typename M>
class MrcalOracle : public ::testing::Test {
 protected:
  static mrcal_lensmodel_t lens_model() {
    std::string name;
    for (const ForeignName& foreign : M::kForeignNames) {
      if (foreign.format == "mrcal") name = foreign.name;
    }
    mrcal_lensmodel_t model{};
    EXPECT_TRUE(mrcal_lensmodel_from_name(&model, name.c_str())) << name;
    EXPECT_EQ(mrcal_lensmodel_num_params(&model), kParameterCount<M>);
    return model;
  }
};
using MrcalModels = ::testing::Types<Pinhole, BrownConrady, Rational, ThinPrism>;
TYPED_TEST_SUITE(MrcalOracle, MrcalModels, ModelTestName);

TYPED_TEST(MrcalOracle, ProjectAgrees) {
  using M = TypeParam;
  const mrcal_lensmodel_t model = TestFixture::lens_model();
  for (const auto& example : M::kExamples) {
    const Camera camera = camera_with_shape<M>(example.shape.data());
    const auto points = points_up_to(example.half_angle_rad);
    const auto count = static_cast<Eigen::Index>(points.size());
    std::vector<mrcal_point3_t> p(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) p[i] = {.x = points[i].x(), .y = points[i].y(), .z = points[i].z()};
    std::vector<mrcal_point2_t> q(points.size());
    std::vector<mrcal_point3_t> q_wrt_p(2 * points.size());
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> q_wrt_intrinsics(2 * count,
                                                                                            kParameterCount<M>);
    ASSERT_TRUE(mrcal_project(q.data(), q_wrt_p.data(), q_wrt_intrinsics.data(), p.data(), static_cast<int>(count),
                              &model, camera.parameters.data()));
    Opinion theirs{Eigen::Matrix<double, Eigen::Dynamic, 2>(count, 2),
                   Eigen::Matrix<double, Eigen::Dynamic, 3>(2 * count, 3), q_wrt_intrinsics};
    for (Eigen::Index i = 0; i < count; ++i) {
      theirs.pixels.row(i) << q[i].x, q[i].y;
      for (Eigen::Index axis = 0; axis < 2; ++axis) {
        const mrcal_point3_t& gradient = q_wrt_p[2 * i + axis];
        theirs.wrt_ray.row(2 * i + axis) << gradient.x, gradient.y, gradient.z;
      }
    }
    expect_same<M>(camera, points, theirs);
  }
}

TYPED_TEST(MrcalOracle, UnprojectAgrees) {
  using M = TypeParam;
  const mrcal_lensmodel_t model = TestFixture::lens_model();
  for (const auto& example : M::kExamples) {
    const Camera camera = camera_with_shape<M>(example.shape.data());
    for (const Eigen::Vector3d& ray : rays_up_to(example.half_angle_rad, 40)) {
      const std::optional<Eigen::Vector2d> pixel = pixel_from_ray(camera, ray);
      ASSERT_TRUE(pixel.has_value());
      const mrcal_point2_t q{.x = pixel->x(), .y = pixel->y()};
      mrcal_point3_t v{};
      ASSERT_TRUE(mrcal_unproject(&v, &q, 1, &model, camera.parameters.data()));
      const std::optional<Eigen::Vector3d> ours = ray_from_pixel(camera, *pixel);
      ASSERT_TRUE(ours.has_value());
      // mrcal's search stops early: 1e-6 rad is well under a thousandth of a pixel
      EXPECT_LT((*ours - Eigen::Vector3d(v.x, v.y, v.z).normalized()).norm(), 1e-6) << ray.transpose();
    }
  }
}

}  // namespace
}  // namespace raybundle

#else

TEST(MrcalOracle, ProjectAgrees) { GTEST_SKIP() << "mrcal is not installed (Debian package libmrcal-dev)"; }

#endif
