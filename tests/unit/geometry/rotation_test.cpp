// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/geometry/rotation.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

namespace raybundle {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Rotation vectors of every size that matters: none, tiny, ordinary, almost half a turn.
std::vector<Vector3d> rotation_vectors() {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::vector<Vector3d> vectors;
  for (const double angle : {0.0, 1e-300, 1e-12, 1e-8, 1e-4, 0.3, 1.5, 3.0, M_PI - 1e-3, M_PI - 1e-7}) {
    for (int i = 0; i < 20; ++i) {
      vectors.push_back(angle * Vector3d(normal(random), normal(random), normal(random)).normalized());
    }
  }
  return vectors;
}

TEST(Rotation, SkewIsTheCrossProduct) {
  const Vector3d a(0.3, -1.2, 0.7);
  const Vector3d b(2.0, 0.1, -0.4);
  EXPECT_LT((skew(a) * b - a.cross(b)).norm(), 1e-15);
}

TEST(Rotation, FromVectorIsARotationAboutThatAxis) {
  for (const Vector3d& vector : rotation_vectors()) {
    const Matrix3d rotation = rotation_from_vector(vector);
    EXPECT_LT((rotation.transpose() * rotation - Matrix3d::Identity()).norm(), 1e-14);
    EXPECT_GT(rotation.determinant(), 0.0);
    EXPECT_LT((rotation * vector - vector).norm(), 1e-14);
    EXPECT_NEAR(rotation.trace(), 1.0 + 2.0 * std::cos(vector.norm()), 1e-14);
  }
}

TEST(Rotation, VectorRoundTrip) {
  for (const Vector3d& vector : rotation_vectors()) {
    // relative to the vector: a tiny rotation must come back as that tiny rotation, not as zero
    EXPECT_LT((vector_from_rotation(rotation_from_vector(vector)) - vector).norm(), 1e-12 * vector.norm() + 1e-15)
        << vector.transpose();
  }
}

TEST(Rotation, HalfTurnComesBackUpToItsSign) {
  const Vector3d vector = M_PI * Vector3d(1, 2, -2) / 3.0;
  const Vector3d again = vector_from_rotation(rotation_from_vector(vector));
  EXPECT_LT(std::min((again - vector).norm(), (again + vector).norm()), 1e-7);
}

TEST(Rotation, NearestRotationKeepsARotationAndUndoesScaleAndReflection) {
  for (const Vector3d& vector : rotation_vectors()) {
    const Matrix3d rotation = rotation_from_vector(vector);
    EXPECT_LT((nearest_rotation(rotation) - rotation).norm(), 1e-13);
    EXPECT_LT((nearest_rotation(3.7 * rotation) - rotation).norm(), 1e-13);
  }
  const Matrix3d reflected = Vector3d(1.0, 0.9, -0.1).asDiagonal();
  EXPECT_GT(nearest_rotation(reflected).determinant(), 0.0);
  EXPECT_LT((nearest_rotation(reflected) - Matrix3d::Identity()).norm(), 1e-14);
}

TEST(Rotation, NearestRotationIsNearerThanItsNeighbours) {
  std::mt19937 random(8);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 30; ++trial) {
    const Matrix3d matrix = Matrix3d::NullaryExpr([&] { return normal(random); });
    const Matrix3d nearest = nearest_rotation(matrix);
    for (int i = 0; i < 20; ++i) {
      const Vector3d turn = 0.05 * Vector3d(normal(random), normal(random), normal(random));
      EXPECT_LE((matrix - nearest).norm(), (matrix - rotation_from_vector(turn) * nearest).norm() + 1e-12);
    }
  }
}

}  // namespace
}  // namespace raybundle
