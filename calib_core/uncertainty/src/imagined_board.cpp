// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "imagined_board.hpp"

#include <Eigen/QR>
#include <memory>
#include <utility>

#include "raybundle/scene/parameter_names.hpp"

namespace raybundle {
namespace {

constexpr std::size_t kFewestCorners = 6;  // by which a camera ties a board to the rig
constexpr Eigen::Index kPoseColumns = 6;
constexpr double kUnseen = 1e-12;  // of the largest: directions of a pose that its corners do not tell

// Where the columns of multiply_view() stand when the pose's come first, then the parameters of the covariance; -1:
// nowhere.
std::vector<int> places_of_columns(const Calibration& calibration, const RigCamera& camera, const Target& target) {
  std::vector<int> all;
  const auto append = [&](const std::vector<std::string>& names) {
    for (const int place : calibration.covariance.places_of(names)) {
      all.push_back(place < 0 ? -1 : static_cast<int>(kPoseColumns) + place);
    }
  };
  append(intrinsic_names(camera));
  for (int k = 0; k < static_cast<int>(kPoseColumns); ++k) all.push_back(k);
  append(shape_names(target.name));
  all.push_back(-1);  // an imagined residual says nothing
  append(extrinsic_names(camera));
  return all;
}

// Of the pose's equations, the upper triangle of whose left side stands first in `products`, in units of what each
// direction would be known to alone.
Eigen::MatrixXd pose_solution(const Eigen::MatrixXd& products, const Eigen::MatrixXd& right) {
  using Matrix6d = Eigen::Matrix<double, kPoseColumns, kPoseColumns>;
  const Matrix6d left = products.topLeftCorner<kPoseColumns, kPoseColumns>();
  const Eigen::Matrix<double, kPoseColumns, 1> scale =
      (left.diagonal().array() > 0.0).select(left.diagonal().array().rsqrt(), 0.0);
  Eigen::ColPivHouseholderQR<Matrix6d> qr;
  qr.setThreshold(kUnseen);
  qr.compute(scale.asDiagonal() * left * scale.asDiagonal());
  return scale.asDiagonal() * qr.solve(scale.asDiagonal() * right);
}

}  // namespace

ImaginedBoard::ImaginedBoard(const Calibration& calibration, int target)
    : calibration_(calibration),
      target_(target),
      basis_(shape_basis(calibration.targets[target].target)),
      surface_(points_on_surface(calibration.targets[target].target, calibration.targets[target].shape)) {
  for (const RigCamera& camera : calibration.cameras) {
    places_.push_back(places_of_columns(calibration, camera, calibration.targets[target].target));
  }
}

std::vector<int> ImaginedBoard::seen_by(int camera, const Rigid3& rig_from_target) const {
  const RigCamera& lens = calibration_.cameras[camera];
  const Rigid3 camera_from_target = lens.camera_from_rig * rig_from_target;
  std::vector<int> seen;
  seen.reserve(surface_.size());
  for (std::size_t i = 0; i < surface_.size(); ++i) {
    const auto pixel = pixel_from_ray(lens.camera, camera_from_target * surface_[i]);
    if (pixel && lens.camera.size.contains(*pixel)) seen.push_back(static_cast<int>(i));
  }
  return seen;
}

ViewData ImaginedBoard::view_of(int camera, const std::vector<int>& points, double sigma_px) const {
  const std::ptrdiff_t count = std::ssize(points);
  return {.view = 0,
          .camera = camera,
          .target = target_,
          .pose = 0,
          .model = calibration_.cameras[camera].camera.model,
          .points = std::make_shared<BoardPoints>(calibration_.targets[target_].target, basis_, points),
          .pixel = Eigen::MatrixX2d::Zero(count, 2),
          .inverse_sigma = Eigen::ArrayXd::Constant(count, 1.0 / sigma_px)};
}

Eigen::MatrixXd ImaginedBoard::information(const Rigid3& rig_from_target, const std::vector<double>& sigma_px) const {
  const auto parameters = static_cast<Eigen::Index>(calibration_.covariance.names.size());
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(kPoseColumns + parameters, kPoseColumns + parameters), of_view;
  for (int c = 0; c < static_cast<int>(calibration_.cameras.size()); ++c) {
    const std::vector<int> seen = seen_by(c, rig_from_target);
    if (seen.size() < kFewestCorners) continue;
    const RigCamera& camera = calibration_.cameras[c];
    const ViewPoint point{camera.camera.parameters.data(), camera.camera_from_rig, rig_from_target,
                          calibration_.targets[target_].shape.sags()};
    if (!multiply_view(view_of(c, seen, sigma_px[c]), point, {.with_shape = true}, of_view)) {
      return Eigen::MatrixXd::Zero(parameters, parameters);
    }
    const std::vector<int>& places = places_[c];
    for (std::size_t b = 0; b < places.size(); ++b) {
      for (std::size_t a = 0; places[b] >= 0 && a < places.size(); ++a) {
        if (places[a] >= 0) products(places[a], places[b]) += of_view(a, b);
      }
    }
  }
  const Eigen::MatrixXd across = products.topRightCorner(kPoseColumns, parameters);
  Eigen::MatrixXd information = products.bottomRightCorner(parameters, parameters);
  information.noalias() -= across.transpose() * pose_solution(products, across);
  return information;
}

}  // namespace raybundle
