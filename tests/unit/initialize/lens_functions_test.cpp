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
void add_examples(const LensFunctions& functions, std::vector<NamedLens>& lenses) {
  for (const auto& example : M::kExamples) {
    NamedLens lens{std::string(M::kName), functions, LensVector(functions.parameters)};
    lens.parameters.head<4>() << 400, 410, 320, 240;
    for (int k = 0; k < kShapeSize<M>; ++k) lens.parameters[4 + k] = example.shape[static_cast<std::size_t>(k)];
    lenses.push_back(lens);
  }
}

std::vector<NamedLens> all_lenses() {
  std::vector<NamedLens> lenses;
  add_examples<StartLens>(start_lens_functions(), lenses);
  for (const std::string_view name : model_names()) {
    const ModelId model = *model_named(name);
    with_model(model, [&]<CameraModel M>() { add_examples<M>(lens_functions(model), lenses); });
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

// Out to where models have no ray left, and with pixels one by one as well as many at a time.
TEST(LensFunctions, RaysOfManyPixelsAreThoseOfEachOfThem) {
  for (const NamedLens& lens : all_lenses()) {
    SCOPED_TRACE(lens.name);
    for (const double reach_px : {50.0, 250.0, 900.0, 4000.0}) {
      std::vector<Eigen::Vector2d> pixels;
      for (int i = 0; i < 21; ++i) {
        const Eigen::Vector2d off_axis(std::cos(2.4 * i), std::sin(2.4 * i));
        pixels.push_back(lens.parameters.segment<2>(2) + reach_px * (i / 21.0) * off_axis);
      }
      for (const std::size_t count : {std::size_t{3}, std::size_t{4}, pixels.size()}) {
        std::vector<Eigen::Vector3d> rays(count);
        lens.functions.unproject_all(lens.parameters.data(), std::span(pixels).first(count), rays.data());
        for (std::size_t i = 0; i < count; ++i) {
          Eigen::Vector3d expected = Eigen::Vector3d::Zero();
          if (lens.functions.unproject(lens.parameters.data(), pixels[i], expected))
            expected.normalize();
          else
            expected.setZero();
          EXPECT_LT((rays[i] - expected).norm(), 1e-8) << reach_px << ' ' << i;  // StartLens bisects to 1e-9
        }
      }
    }
  }
}

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
      if (!projects) continue;
      const Eigen::Vector2d error = pixel - view.pixels[i];
      const double weight = kScale_px * kScale_px / (kScale_px * kScale_px + error.squaredNorm());
      if (weight < 1e-6) continue;  // one that is that far off does not count
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
