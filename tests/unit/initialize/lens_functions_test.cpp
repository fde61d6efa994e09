// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "../../../calib_core/initialize/src/lens_functions.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "../../../calib_core/initialize/src/start_lens.hpp"

namespace raybundle {
namespace {

struct NamedLens {
  std::string name;
  LensFunctions functions;
  LensVector parameters;
};

template <CameraModel M>
NamedLens with_example(const LensFunctions& functions) {
  NamedLens lens{std::string(M::kName), functions, LensVector(functions.parameters)};
  lens.parameters.head<4>() << 400, 410, 320, 240;
  for (int k = 0; k < kShapeSize<M>; ++k) {
    lens.parameters[4 + k] = M::kExamples.front().shape[static_cast<std::size_t>(k)];
  }
  return lens;
}

std::vector<NamedLens> all_lenses() {
  std::vector<NamedLens> lenses{with_example<StartLens>(start_lens_functions())};
  for (const std::string_view name : model_names()) {
    const ModelId model = *model_named(name);
    lenses.push_back(with_model(model, [&]<CameraModel M>() { return with_example<M>(lens_functions(model)); }));
  }
  return lenses;
}

constexpr double kScale_px = 3.0;

/// Eleven corners, so that some are left when four at a time are taken; one of them far from where it is seen, and one
/// behind the camera.
PointsInView view_of(const NamedLens& lens, const Rigid3& pose) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, 1.0);
  PointsInView view;
  for (int i = 0; i < 11; ++i) {
    const Eigen::Vector3d point(0.05 * (i % 4), 0.04 * (i / 4), 0.01 * noise(random));
    Eigen::Vector2d pixel(0, 0);
    lens.functions.project(lens.parameters.data(), pose * point, pixel);
    view.points.push_back(point);
    view.pixels.push_back(pixel + Eigen::Vector2d(noise(random), noise(random)));
  }
  view.pixels[5].x() += 1e4;
  view.points[6] = pose.inverse() * Eigen::Vector3d(1e-3, 0, -1);
  return view;
}

const Rigid3 kPose{Eigen::Quaterniond(Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 0.5).normalized())),
                   Eigen::Vector3d(-0.05, 0.02, 0.3)};

TEST(LensFunctions, DistancesOfAViewAreThoseOfItsCorners) {
  for (const NamedLens& lens : all_lenses()) {
    SCOPED_TRACE(lens.name);
    const PointsInView view = view_of(lens, kPose);
    std::vector<double> distances2;
    lens.functions.squared_distances(lens.parameters.data(), view, kPose, distances2);
    ASSERT_EQ(distances2.size(), view.points.size());
    for (std::size_t i = 0; i < view.points.size(); ++i) {
      Eigen::Vector2d pixel;
      const bool projects = lens.functions.project(lens.parameters.data(), kPose * view.points[i], pixel);
      if (projects) {
        const double expected = (pixel - view.pixels[i]).squaredNorm();
        EXPECT_NEAR(distances2[i], expected, 1e-9 * (1.0 + expected)) << i;  // rounding
      } else {
        EXPECT_EQ(distances2[i], INFINITY) << i;
      }
    }
  }
}

TEST(LensFunctions, RowsOfAViewAreTheWeighedDerivativesOfItsCorners) {
  for (const NamedLens& lens : all_lenses()) {
    SCOPED_TRACE(lens.name);
    const PointsInView view = view_of(lens, kPose);
    const int n = lens.functions.parameters;
    LensRows rows;
    lens.functions.linearise(lens.parameters.data(), view, kPose, kScale_px, rows);
    Eigen::MatrixXd expected[2] = {Eigen::MatrixXd::Zero(12, n + 7), Eigen::MatrixXd::Zero(12, n + 7)};
    for (std::size_t i = 0; i < view.points.size(); ++i) {
      Eigen::Vector2d pixel;
      Eigen::Matrix<double, 2, 3, Eigen::RowMajor> wrt_ray;
      Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor> wrt_lens(2, n);
      const Eigen::Vector3d arm = kPose.rotation * view.points[i], ray = arm + kPose.translation;
      const bool projects =
          lens.functions.project_with_jacobians(lens.parameters.data(), ray, pixel, wrt_ray, wrt_lens.data());
      if (!projects || i == 5) continue;  // the one that is far off does not count
      const Eigen::Vector2d error = pixel - view.pixels[i];
      const double weight = kScale_px * kScale_px / (kScale_px * kScale_px + error.squaredNorm());
      for (int axis = 0; axis < 2; ++axis) {
        auto row = expected[axis].row(static_cast<Eigen::Index>(i));
        const Eigen::Vector3d slope = wrt_ray.row(axis);
        row << wrt_lens.row(axis), arm.cross(slope).transpose(), slope.transpose(), error[axis];
        row *= weight;
      }
    }
    for (int axis = 0; axis < 2; ++axis) {
      ASSERT_EQ(rows.of_axis[axis].rows(), 12);  // 11 corners up to a multiple of four
      ASSERT_EQ(rows.of_axis[axis].cols(), n + 5);
      Eigen::MatrixXd all = Eigen::MatrixXd::Zero(12, n + 7);
      for (int k = 0; k < n + 5; ++k) all.col(LensRows::index(axis, k)) = rows.of_axis[axis].col(k);
      EXPECT_LT((all - expected[axis]).norm(), 1e-9 * expected[axis].norm());  // rounding
    }
  }
}

}  // namespace
}  // namespace raybundle
