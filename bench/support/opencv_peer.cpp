// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "opencv_peer.hpp"

#include <opencv2/calib3d.hpp>

#include "raybundle/geometry/rotation.hpp"

namespace raybundle::bench {
namespace {

struct Corners {
  std::vector<std::vector<cv::Point3f>> points;
  std::vector<std::vector<cv::Point2f>> pixels;
};

struct Answer {
  cv::Mat k, distortion;
  std::vector<cv::Mat> rotations, translations;
};

Corners corners_of(const testing::RandomRig& rig, bool right_only) {
  Corners corners;
  for (std::size_t v = 0; v < rig.problem.views.size(); ++v) {
    std::vector<cv::Point3f> points;
    std::vector<cv::Point2f> pixels;
    const std::vector<Observation>& observations = rig.problem.views[v].observations;
    for (std::size_t i = 0; i < observations.size(); ++i) {
      if (right_only && rig.truth.fates[v][i] != ObservationFate::kUsed) continue;
      const Eigen::Vector3f x = rig.problem.targets[0].find(observations[i].point_id)->x_in_target.cast<float>();
      points.emplace_back(x.x(), x.y(), 0.0F);
      const Eigen::Vector2f pixel = observations[i].pixel.cast<float>();
      pixels.emplace_back(pixel.x(), pixel.y());
    }
    corners.points.push_back(std::move(points));
    corners.pixels.push_back(std::move(pixels));
  }
  return corners;
}

Answer perspective(const Corners& corners, cv::Size size, std::string_view model) {
  int flags = 0;
  if (model == "pinhole") {
    flags = cv::CALIB_FIX_K1 | cv::CALIB_FIX_K2 | cv::CALIB_FIX_K3 | cv::CALIB_ZERO_TANGENT_DIST;
  } else if (model == "rational") {
    flags = cv::CALIB_RATIONAL_MODEL;
  } else if (model == "thin_prism") {
    flags = cv::CALIB_RATIONAL_MODEL | cv::CALIB_THIN_PRISM_MODEL;
  }
  Answer answer;
  const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-12);
  cv::calibrateCamera(corners.points, corners.pixels, size, answer.k, answer.distortion, answer.rotations,
                      answer.translations, flags, until);
  return answer;
}

Answer fisheye(const Corners& corners, cv::Size size) {
  Answer answer;
  const int flags = cv::fisheye::CALIB_RECOMPUTE_EXTRINSIC | cv::fisheye::CALIB_FIX_SKEW;
  const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-12);
  cv::fisheye::calibrate(corners.points, corners.pixels, size, answer.k, answer.distortion, answer.rotations,
                         answer.translations, flags, until);
  return answer;
}

Rigid3 pose_of(const cv::Mat& rotation, const cv::Mat& translation) {
  const cv::Mat_<double> r(rotation), t(translation);
  Rigid3 pose;
  pose.rotation = Eigen::Quaterniond(rotation_from_vector({r(0), r(1), r(2)}));
  pose.translation << t(0), t(1), t(2);
  return pose;
}

}  // namespace

bool opencv_has(std::string_view model) {
  for (const char* name : {"pinhole", "brown_conrady", "rational", "thin_prism", "kannala_brandt"}) {
    if (model == name) return true;
  }
  return false;
}

std::optional<BundleState> calibrate_with_opencv(const testing::RandomRig& rig, bool right_only) {
  const std::string_view model = model_name(rig.problem.cameras[0].model);
  const ImageSize size = rig.problem.cameras[0].size;
  try {
    const Corners corners = corners_of(rig, right_only);
    const cv::Size cv_size(size.width, size.height);
    const Answer answer = model == "kannala_brandt" ? fisheye(corners, cv_size) : perspective(corners, cv_size, model);
    BundleState state = rig.truth;
    const cv::Mat_<double> k(answer.k), distortion(answer.distortion.reshape(1, 1));
    Eigen::VectorXd& parameters = state.cameras[0].parameters;
    parameters.head<4>() << k(0, 0), k(1, 1), k(0, 2), k(1, 2);
    for (Eigen::Index i = 4; i < parameters.size(); ++i) parameters[i] = distortion(0, static_cast<int>(i - 4));
    for (std::size_t v = 0; v < state.poses.size(); ++v) {
      state.poses[v].rig_from_target = pose_of(answer.rotations[v], answer.translations[v]);
    }
    return state;
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
}

}  // namespace raybundle::bench
