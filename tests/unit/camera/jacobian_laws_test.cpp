// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "law_support.hpp"

namespace raybundle {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

template <typename M>
class JacobianLaws : public ::testing::Test {
 protected:
  static constexpr int kCount = kParameterCount<M>;
  using WrtRay = Eigen::Matrix<double, 2, 3, Eigen::RowMajor>;
  using WrtParameters = Eigen::Matrix<double, 2, kCount, Eigen::RowMajor>;

  struct Analytic {
    Vector2d pixel;
    WrtRay wrt_ray;
    WrtParameters wrt_parameters;
  };

  static Analytic analytic(const Camera& camera, const Vector3d& ray) {
    Analytic result;
    EXPECT_TRUE(pixel_from_ray<M>(camera.parameters.data(), ray, result.pixel, result.wrt_ray, result.wrt_parameters));
    return result;
  }
};
TYPED_TEST_SUITE(JacobianLaws, AsTestTypes<Models>::Type, ModelTestName);

TYPED_TEST(JacobianLaws, EqualTheAutomaticDerivatives) {
  using M = TypeParam;
  constexpr int kCount = TestFixture::kCount;
  using Jet = ceres::Jet<double, kCount + 3>;
  for (const auto& example : M::kExamples) {
    const Camera camera = camera_with_shape<M>(example.shape.data());
    for (const Vector3d& unit : rays_up_to(example.half_angle_rad)) {
      const Vector3d ray = 1.7 * unit;
      const auto own = TestFixture::analytic(camera, ray);
      Jet parameters[kCount];
      Jet jet_ray[3];
      Jet pixel[2];
      for (int i = 0; i < kCount; ++i) parameters[i] = Jet(camera.parameters[i], i);
      for (int i = 0; i < 3; ++i) jet_ray[i] = Jet(ray[i], kCount + i);
      ASSERT_TRUE((pixel_from_ray<M, Jet>(parameters, jet_ray, pixel)));
      for (int axis = 0; axis < 2; ++axis) {
        EXPECT_NEAR(own.pixel[axis], pixel[axis].a, 1e-10);
        for (int i = 0; i < kCount + 3; ++i) {
          const double ours = i < kCount ? own.wrt_parameters(axis, i) : own.wrt_ray(axis, i - kCount);
          // 1e-10 relative to the size of the row: both sides round in another order
          EXPECT_NEAR(ours, pixel[axis].v[i], 1e-10 * std::max(1.0, pixel[axis].v.norm()))
              << "axis " << axis << " column " << i << " ray " << ray.transpose();
        }
      }
    }
  }
}

TYPED_TEST(JacobianLaws, EqualTheNumericDerivatives) {
  using M = TypeParam;
  constexpr double kStep = 1e-6;
  for (const auto& example : M::kExamples) {
    const Camera camera = camera_with_shape<M>(example.shape.data());
    for (const Vector3d& ray : rays_up_to(0.97 * example.half_angle_rad, 60)) {
      const auto own = TestFixture::analytic(camera, ray);
      const auto expect_close = [&](const Vector2d& column, const Vector2d& plus, const Vector2d& minus) {
        const Vector2d numeric = (plus - minus) / (2 * kStep);
        // central differences: third derivative times step² and rounding of 1e-13 px over the step
        EXPECT_LT((column - numeric).norm(), 1e-5 * (1.0 + numeric.norm()));
      };
      for (int i = 0; i < TestFixture::kCount; ++i) {
        Camera plus = camera;
        Camera minus = camera;
        plus.parameters[i] += kStep;
        minus.parameters[i] -= kStep;
        expect_close(own.wrt_parameters.col(i), TestFixture::analytic(plus, ray).pixel,
                     TestFixture::analytic(minus, ray).pixel);
      }
      for (int i = 0; i < 3; ++i) {
        const Vector3d step = kStep * Vector3d::Unit(i);
        expect_close(own.wrt_ray.col(i), TestFixture::analytic(camera, ray + step).pixel,
                     TestFixture::analytic(camera, ray - step).pixel);
      }
    }
  }
}

TYPED_TEST(JacobianLaws, AlongTheRayNothingMoves) {
  using M = TypeParam;
  for (const auto& example : M::kExamples) {
    const Camera camera = camera_with_shape<M>(example.shape.data());
    for (const Vector3d& ray : rays_up_to(example.half_angle_rad)) {
      const auto own = TestFixture::analytic(camera, ray);
      EXPECT_LT((own.wrt_ray * ray).norm(), 1e-12 * (1.0 + own.wrt_ray.norm()));
    }
  }
}

// Four rays at once give what they give one by one, or say that they have no common answer, as here those near the
// axis may.
TYPED_TEST(JacobianLaws, AreTheSameInLanes) {
  using M = TypeParam;
  constexpr int n = kShapeSize<M>, kSome = std::max(n, 1);
  for (const auto& example : M::kExamples) {
    const std::vector<Vector3d> rays = rays_up_to(example.half_angle_rad);
    std::size_t taken = 0;
    for (std::size_t first = 0; first + Lanes::kCount <= rays.size(); first += Lanes::kCount) {
      Lanes shape[kSome], ray[3], plane[2], wrt_ray[6], wrt_shape[2 * kSome] = {};
      for (int k = 0; k < n; ++k) shape[k] = Lanes(example.shape[k]);
      load(&rays[first], ray);
      Lanes::disagreed = false;
      if (!M::plane_from_ray(shape, ray, plane, wrt_ray, wrt_shape) || Lanes::disagreed) continue;
      ++taken;
      for (int lane = 0; lane < Lanes::kCount; ++lane) {
        double one[2], one_wrt_ray[6], one_wrt_shape[2 * kSome] = {};
        ASSERT_TRUE(
            M::plane_from_ray(example.shape.data(), rays[first + lane].data(), one, one_wrt_ray, one_wrt_shape));
        // both sides round in another order
        const auto expect_same = [&](const Lanes* lanes, const double* numbers, int count) {
          const double size = Eigen::Map<const Eigen::VectorXd>(numbers, count).norm();
          for (int i = 0; i < count; ++i) EXPECT_NEAR(lanes[i][lane], numbers[i], 1e-13 * std::max(1.0, size));
        };
        expect_same(plane, one, 2);
        expect_same(wrt_ray, one_wrt_ray, 6);
        expect_same(wrt_shape, one_wrt_shape, 2 * n);
      }
    }
    EXPECT_GE(taken + 2, rays.size() / Lanes::kCount);
  }
}

}  // namespace
}  // namespace raybundle
