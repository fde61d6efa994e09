// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Domains of models under random shapes: the laws use a few realistic ones, a solver visits others on its way.
#include <gtest/gtest.h>

#include <random>

#include "law_support.hpp"

namespace raybundle {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

double radius_at(auto project, const double* shape, double angle) {
  Vector2d plane;
  return project(shape, ray_at(angle, 0.4).data(), plane.data()) ? plane.norm() : -1.0;
}

/// The radius grows up to the angle that the model names, the inverse returns each ray, and the model ends there.
template <CameraModel M>
void expect_exact_domain(const double* shape) {
  const auto project = [](const double* s, const double* ray, double* plane) {
    return M::plane_from_ray(s, ray, plane);
  };
  const double limit = M::max_angle_rad(shape);
  double last = -1.0;
  for (int i = 0; i <= 200; ++i) {
    const double angle = 0.9999 * limit * i / 200;
    const double radius = radius_at(project, shape, angle);
    ASSERT_GT(radius, last) << "at " << angle << " of " << limit;
    last = radius;
    if (radius > 1e3 || i > 190) continue;  // close to the end the inverse is ill-conditioned
    const Vector3d ray = ray_at(angle, 0.4);
    Vector2d plane;
    Vector3d again;
    ASSERT_TRUE(project(shape, ray.data(), plane.data()));
    ASSERT_TRUE(M::ray_from_plane(shape, plane.data(), again.data())) << angle << " of " << limit;
    ASSERT_LT((again - ray).norm(), 1e-10) << angle << " of " << limit;
  }
  if (limit < M_PI - 1e-3) {
    EXPECT_LT(radius_at(project, shape, limit + 1e-3), last * (1 + 1e-3));
  }
  if constexpr (requires { M::grows_up_to(shape, limit); }) {
    EXPECT_TRUE(M::grows_up_to(shape, 1e-6));
    EXPECT_FALSE(limit < M_PI - 1e-3 && M::grows_up_to(shape, limit + 1e-6)) << limit;
  }
}

TEST(Domain, DoubleSphereUnderRandomShapes) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> xi(-0.95, 1.5);
  std::uniform_real_distribution<double> alpha(-0.5, 1.2);
  for (int i = 0; i < 500; ++i) {
    const double shape[] = {xi(random), alpha(random)};
    SCOPED_TRACE(testing::Message() << "xi " << shape[0] << " alpha " << shape[1]);
    expect_exact_domain<DoubleSphere>(shape);
    if (HasFatalFailure()) return;
  }
}

TEST(Domain, ExtendedUnifiedUnderRandomShapes) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> alpha(-0.5, 1.2);
  std::uniform_real_distribution<double> beta(0.3, 3.0);
  for (int i = 0; i < 500; ++i) {
    const double shape[] = {alpha(random), beta(random)};
    SCOPED_TRACE(testing::Message() << "alpha " << shape[0] << " beta " << shape[1]);
    expect_exact_domain<ExtendedUnified>(shape);
    if (HasFatalFailure()) return;
  }
}

TEST(Domain, UnifiedUnderRandomShapes) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> xi(-0.5, 3.0);
  std::normal_distribution<double> k(0.0, 0.2);
  for (int i = 0; i < 500; ++i) {
    const double shape[] = {xi(random), k(random), k(random), 0.0, 0.0};
    SCOPED_TRACE(testing::Message() << "xi " << shape[0] << " k1 " << shape[1] << " k2 " << shape[2]);
    expect_exact_domain<Unified>(shape);
    if (HasFatalFailure()) return;
  }
}

TEST(Domain, KannalaBrandtUnderRandomShapes) {
  std::mt19937 random(4);
  std::normal_distribution<double> k(0.0, 0.05);
  for (int i = 0; i < 500; ++i) {
    const double shape[] = {k(random), k(random), k(random), k(random)};
    SCOPED_TRACE(testing::Message() << shape[0] << " " << shape[1] << " " << shape[2] << " " << shape[3]);
    expect_exact_domain<KannalaBrandt>(shape);
    if (HasFatalFailure()) return;
  }
}

TEST(Domain, RationalUnderRandomShapes) {
  std::mt19937 random(5);
  std::normal_distribution<double> k(0.0, 0.3);
  for (int i = 0; i < 500; ++i) {
    const double shape[] = {k(random), k(random), 0, 0, k(random), k(random), k(random), k(random)};
    SCOPED_TRACE(testing::Message() << shape[0] << " " << shape[1] << " " << shape[4] << " " << shape[5] << " "
                                    << shape[6] << " " << shape[7]);
    expect_exact_domain<Rational>(shape);
    if (HasFatalFailure()) return;
  }
}

TEST(Domain, RefusesShapesThatAreNoLens) {
  const Vector3d axis(0, 0, 1);
  Vector2d plane;
  EXPECT_FALSE(ExtendedUnified::plane_from_ray(std::array{0.5, -1.0}.data(), axis.data(), plane.data()));
  EXPECT_FALSE(DoubleSphere::plane_from_ray(std::array{-1.5, 0.5}.data(), axis.data(), plane.data()));
  EXPECT_FALSE(Unified::plane_from_ray(std::array{-1.5, 0.0, 0.0, 0.0, 0.0}.data(), axis.data(), plane.data()));
  EXPECT_FALSE(FieldOfView::plane_from_ray(std::array{3.5}.data(), axis.data(), plane.data()));
  EXPECT_EQ(ExtendedUnified::max_angle_rad(std::array{0.5, -1.0}.data()), 0.0);
  EXPECT_EQ(DoubleSphere::max_angle_rad(std::array{-1.5, 0.5}.data()), 0.0);
}

}  // namespace
}  // namespace raybundle
