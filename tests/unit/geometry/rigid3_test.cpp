// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/geometry/rigid3.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "raybundle/geometry/rotation.hpp"

namespace raybundle {
namespace {

using Eigen::Vector3d;
using Motion = Eigen::Matrix<double, 6, 1>;

class Rigid3Laws : public ::testing::Test {
 protected:
  double normal() { return normal_(random_); }
  Vector3d vector() { return {normal(), normal(), normal()}; }
  Rigid3 transform() { return {Eigen::Quaterniond(normal(), normal(), normal(), normal()).normalized(), vector()}; }

  /// Largest displacement of points within about a metre of the origin.
  double distance(const Rigid3& a, const Rigid3& b) {
    double largest = 0;
    for (const Vector3d& x : {Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(0, 1, 0), Vector3d(0, 0, 1)}) {
      largest = std::max(largest, (a * x - b * x).norm());
    }
    return largest;
  }

 private:
  std::mt19937 random_{11};
  std::normal_distribution<double> normal_;
};

TEST_F(Rigid3Laws, CompositionIsApplicationInTurn) {
  for (int i = 0; i < 50; ++i) {
    const Rigid3 c_from_b = transform();
    const Rigid3 b_from_a = transform();
    const Vector3d x_in_a = vector();
    EXPECT_LT(((c_from_b * b_from_a) * x_in_a - c_from_b * (b_from_a * x_in_a)).norm(), 1e-13);
  }
}

TEST_F(Rigid3Laws, CompositionIsAssociative) {
  for (int i = 0; i < 50; ++i) {
    const Rigid3 a = transform();
    const Rigid3 b = transform();
    const Rigid3 c = transform();
    EXPECT_LT(distance((a * b) * c, a * (b * c)), 1e-13);
  }
}

TEST_F(Rigid3Laws, InverseUndoes) {
  for (int i = 0; i < 50; ++i) {
    const Rigid3 b_from_a = transform();
    EXPECT_LT(distance(b_from_a.inverse() * b_from_a, Rigid3{}), 1e-13);
    EXPECT_LT(distance(b_from_a * b_from_a.inverse(), Rigid3{}), 1e-13);
  }
}

TEST_F(Rigid3Laws, RotationKeepsUnitNormThroughManyCompositions) {
  Rigid3 chain;
  const Rigid3 step = transform();
  for (int i = 0; i < 10000; ++i) chain = step * chain;
  EXPECT_NEAR(chain.rotation.norm(), 1.0, 1e-14);
}

TEST_F(Rigid3Laws, MotionBetweenUndoesPerturbed) {
  for (const double size : {1e-12, 1e-6, 1e-2, 0.5}) {
    for (int i = 0; i < 30; ++i) {
      const Rigid3 from = transform();
      Motion motion;
      for (int k = 0; k < 6; ++k) motion[k] = size * normal();
      const Rigid3 to = perturbed(from, motion);
      EXPECT_LT((motion_between(from, to) - motion).norm(), 1e-14);  // translations of size 1 round at 1e-16
      EXPECT_LT(distance(perturbed(from, motion_between(from, to)), to), 1e-14);
    }
  }
}

TEST_F(Rigid3Laws, MotionBetweenReachesAnyTransformByTheShortWay) {
  for (int i = 0; i < 100; ++i) {
    const Rigid3 from = transform();
    Rigid3 to = transform();
    const Motion motion = motion_between(from, to);
    EXPECT_LT(distance(perturbed(from, motion), to), 1e-12);
    EXPECT_LE(motion.head<3>().norm(), M_PI + 1e-12);
    to.rotation.coeffs() *= -1.0;  // the other quaternion of the same rotation
    EXPECT_LT((motion_between(from, to) - motion).norm(), 1e-12);
  }
}

TEST_F(Rigid3Laws, PerturbedTurnsInTheTargetFrame) {
  const Rigid3 b_from_a = transform();
  Motion motion;
  motion << 0.1, -0.2, 0.3, 0.01, 0.02, 0.03;
  const Vector3d x_in_a = vector();
  const Vector3d expected =
      rotation_from_vector(motion.head<3>()) * (b_from_a.rotation * x_in_a) + b_from_a.translation + motion.tail<3>();
  EXPECT_LT((perturbed(b_from_a, motion) * x_in_a - expected).norm(), 1e-14);
}

TEST_F(Rigid3Laws, AngleBetweenIsTheLengthOfTheTurn) {
  for (int i = 0; i < 50; ++i) {
    const Rigid3 a = transform();
    Rigid3 b = transform();
    EXPECT_NEAR(angle_between(a, b), motion_between(a, b).head<3>().norm(), 1e-12);
    b.rotation.coeffs() *= -1.0;
    EXPECT_NEAR(angle_between(a, b), motion_between(a, b).head<3>().norm(), 1e-12);
    EXPECT_NEAR(angle_between(a, a), 0.0, 1e-14);
  }
}

}  // namespace
}  // namespace raybundle
