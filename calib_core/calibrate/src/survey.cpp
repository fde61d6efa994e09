// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/calibrate/survey.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/rotation.hpp"
#include "raybundle/initialize/target_pose.hpp"
#include "raybundle/uncertainty/projection_uncertainty.hpp"
#include "survey_stage.hpp"

namespace raybundle {
namespace {

using Motion = Eigen::Matrix<double, 6, 1>;
using Information = Eigen::Matrix<double, 6, 6>;

constexpr double kStartThreshold_rad = 0.02;  // of the first pose: a mistaken landmark is off by more
constexpr double kOutlierSigmas = 4.0;
constexpr int kMostIterations = 50;
constexpr int kMostRounds = 10;  // until the landmarks that are left out stay the same

struct Pair {
  const Landmark* landmark;
  Eigen::Vector2d pixel;
  bool used = true;
  Eigen::Matrix2d of_calibration = Eigen::Matrix2d::Zero();  // covariance of a pixel there by the lens [px²]
};

struct Prediction {
  Eigen::Vector2d residual;                // seen minus predicted [px]
  Eigen::Matrix<double, 2, 6> wrt_motion;  // of the predicted pixel
  Eigen::Matrix2d own_covariance;          // of sighting and landmark [px²]
  Eigen::Matrix2d covariance;              // of sighting, landmark and lens
};

Eigen::Vector3d in_camera(const Rigid3& camera_from_local, const Landmark& landmark) {
  return landmark.infinitely_far ? Eigen::Vector3d(camera_from_local.rotation * landmark.x_in_local)
                                 : camera_from_local * landmark.x_in_local;
}

// Central differences; the derivative with the length of the ray is zero by itself.
std::optional<Eigen::Matrix<double, 2, 3>> pixel_wrt_point(const Camera& camera, const Eigen::Vector3d& x) {
  const double step = 1e-6 * x.norm();
  Eigen::Matrix<double, 2, 3> derivative;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d offset = step * Eigen::Vector3d::Unit(axis);
    const auto ahead = pixel_from_ray(camera, x + offset), behind = pixel_from_ray(camera, x - offset);
    if (!ahead || !behind) return std::nullopt;
    derivative.col(axis) = (*ahead - *behind) / (2 * step);
  }
  return derivative;
}

std::optional<Prediction> predict(const Camera& camera, const Rigid3& camera_from_local, const Pair& pair,
                                  double sighting_sigma_px) {
  const Landmark& landmark = *pair.landmark;
  const Eigen::Vector3d x = in_camera(camera_from_local, landmark);
  if (!(x.norm() > 0.0)) return std::nullopt;
  const auto pixel = pixel_from_ray(camera, x);
  const auto wrt_point = pixel_wrt_point(camera, x);
  if (!pixel || !wrt_point) return std::nullopt;
  Prediction prediction;
  prediction.residual = pair.pixel - *pixel;
  prediction.wrt_motion.leftCols<3>() = -*wrt_point * skew(camera_from_local.rotation * landmark.x_in_local);
  prediction.wrt_motion.rightCols<3>() = landmark.infinitely_far ? Eigen::Matrix<double, 2, 3>::Zero() : *wrt_point;
  prediction.own_covariance = std::pow(sighting_sigma_px, 2) * Eigen::Matrix2d::Identity() +
                              std::pow(landmark.sigma, 2) * *wrt_point * wrt_point->transpose();
  prediction.covariance = prediction.own_covariance + pair.of_calibration;
  return prediction;
}

// Rotation that turns directions onto rays. Source: Wahba's problem by Kabsch 1976.
Rigid3 pose_from_directions(const std::vector<Eigen::Vector3d>& directions, const std::vector<Eigen::Vector3d>& rays) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < rays.size(); ++i) sum += rays[i] * directions[i].transpose();
  Rigid3 pose;
  pose.rotation = Eigen::Quaterniond(nearest_rotation(sum));
  return pose;
}

[[noreturn]] void refuse_image(const std::string& image) {
  throw Error(ErrorKind::kNotEnoughData,
              "no place of the camera explains where its landmarks are seen; are names, coordinates and their units "
              "right, and the pixels of this camera?",
              image);
}

Rigid3 start_pose(const Camera& camera, const std::vector<Pair>& pairs, const std::string& image) {
  std::vector<Eigen::Vector3d> points, point_rays, directions, direction_rays;
  for (const Pair& pair : pairs) {
    const auto ray = ray_from_pixel(camera, pair.pixel);
    if (!ray) continue;  // beyond what the calibration knows of the lens
    (pair.landmark->infinitely_far ? directions : points).push_back(pair.landmark->x_in_local);
    (pair.landmark->infinitely_far ? direction_rays : point_rays).push_back(*ray);
  }
  const std::size_t without_ray = pairs.size() - points.size() - directions.size();
  if (points.empty() && directions.size() >= 2) return pose_from_directions(directions, direction_rays);
  if (points.size() < 4) {
    throw Error(
        ErrorKind::kNotEnoughData,
        fmt::format("{} points and {} directions do not place the camera; four points do, or two directions and "
                    "no point{}",
                    points.size(), directions.size(),
                    without_ray == 0 ? ""
                                     : fmt::format(". {} more are seen where the calibration has no ray; is it the "
                                                   "right camera, and the image not resized?",
                                                   without_ray)),
        image);
  }
  const auto pose = robust_target_pose(points, point_rays, kStartThreshold_rad);
  if (!pose) refuse_image(image);
  return pose->camera_from_target;
}

struct Refined {
  Rigid3 pose;
  Information information = Information::Zero();  // of its motion
};

// Gauss-Newton over the pairs in use. A direction of the motion that nothing sees is left alone.
Refined refine(const Camera& camera, const std::vector<Pair>& pairs, double sigma_px, Refined state) {
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    state.information.setZero();
    Motion wanted = Motion::Zero();
    for (const Pair& pair : pairs) {
      if (!pair.used) continue;
      const auto prediction = predict(camera, state.pose, pair, sigma_px);
      if (!prediction) continue;
      const Eigen::Matrix<double, 6, 2> weighted =
          prediction->covariance.ldlt().solve(prediction->wrt_motion).transpose();
      state.information += weighted * prediction->wrt_motion;
      wanted += weighted * prediction->residual;
    }
    const Motion step = state.information.completeOrthogonalDecomposition().solve(wanted);
    state.pose = perturbed(state.pose, step);
    if (step.dot(state.information * step) < 1e-12) break;
  }
  return state;
}

// Of a direction that nothing determines NaN.
Motion sigmas_of(const Information& information) {
  Motion sigmas = Motion::Constant(std::numeric_limits<double>::quiet_NaN());
  const bool rotation_only = information.bottomRightCorner<3, 3>().isZero(0.0);
  const int size = rotation_only ? 3 : 6;
  const Eigen::MatrixXd block = information.topLeftCorner(size, size);
  const Eigen::LDLT<Eigen::MatrixXd> factor(block);
  if (factor.info() != Eigen::Success || !factor.isPositive()) return sigmas;
  sigmas.head(size) = factor.solve(Eigen::MatrixXd::Identity(size, size)).diagonal().cwiseSqrt();
  return sigmas;
}

// Moves the local frame to the camera, which coordinates of kilometres need for their digits.
std::vector<Landmark> seen_from(const std::vector<Pair>& pairs, const Eigen::Vector3d& centre) {
  std::vector<Landmark> moved;
  for (const Pair& pair : pairs) {
    moved.push_back(*pair.landmark);
    if (!moved.back().infinitely_far) moved.back().x_in_local -= centre;
  }
  return moved;
}

LandmarkResidual residual_of(const Camera& camera, const Rigid3& pose, const Pair& pair, double sigma_px) {
  LandmarkResidual result{pair.landmark->name, pair.pixel, {NAN, NAN}, INFINITY, NAN, NAN, NAN, pair.used};
  if (!pair.landmark->infinitely_far) result.range_m = in_camera(pose, *pair.landmark).norm();
  const auto prediction = predict(camera, pose, pair, sigma_px);
  if (!prediction) {  // as if it were on the axis
    const double sigma_rad = pair.landmark->sigma / (pair.landmark->infinitely_far ? 1.0 : result.range_m);
    result.own_sigma_px = std::hypot(sigma_px, camera.fx() * sigma_rad);
    return result;
  }
  result.residual_px = prediction->residual;
  result.own_sigma_px = std::sqrt(prediction->own_covariance.trace() / 2);
  result.sigma_px = std::sqrt(prediction->covariance.trace() / 2);
  result.sigmas = std::sqrt(prediction->residual.dot(prediction->covariance.ldlt().solve(prediction->residual)));
  return result;
}

// At first those that the start pose puts near to where they are seen; all when these are few, as where directions that
// are wrong have turned it.
void choose_near(const Camera& camera, const Rigid3& pose, std::vector<Pair>& pairs) {
  for (Pair& pair : pairs) {
    const auto ray = ray_from_pixel(camera, pair.pixel);
    const Eigen::Vector3d expected = in_camera(pose, *pair.landmark).normalized();
    pair.used = ray && (ray->normalized() - expected).norm() < kStartThreshold_rad;
  }
  const auto near = std::ranges::count(pairs, true, &Pair::used);
  if (near >= 4 && 2 * near >= std::ssize(pairs)) return;
  for (Pair& pair : pairs) pair.used = true;
}

// Those that fit, but not fewer than three quarters, the best ones; whether that changes anything.
bool choose_fitting(const std::vector<LandmarkResidual>& landmarks, std::vector<Pair>& pairs) {
  std::vector<double> sigmas;
  for (const LandmarkResidual& landmark : landmarks) {
    sigmas.push_back(std::isnan(landmark.sigmas) ? INFINITY : landmark.sigmas);
  }
  std::vector<double> sorted = sigmas;
  std::ranges::sort(sorted);
  const double limit = std::max(kOutlierSigmas, sorted[sorted.size() - 1 - sorted.size() / 4]);
  bool changed = false;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const bool fits = sigmas[i] <= limit;
    changed = changed || fits != pairs[i].used;
    pairs[i].used = fits;
  }
  return changed;
}

SurveyImage image_of(const Camera& camera, const std::string& image, std::vector<Pair> pairs, double sigma_px,
                     const std::optional<ProjectionUncertainty>& uncertainty) {
  const Rigid3 start = start_pose(camera, pairs, image);
  const Eigen::Vector3d centre = start.inverse().translation;
  const std::vector<Landmark> moved = seen_from(pairs, centre);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    pairs[i].landmark = &moved[i];
    const double range_m = moved[i].infinitely_far ? INFINITY : moved[i].x_in_local.norm();
    const auto covariance = uncertainty ? projection_covariance(*uncertainty, pairs[i].pixel, range_m) : std::nullopt;
    if (covariance) pairs[i].of_calibration = *covariance;
  }
  Refined refined{{start.rotation, Eigen::Vector3d::Zero()}, {}};
  SurveyImage result;
  const auto judge = [&] {
    result.landmarks.clear();
    for (const Pair& pair : pairs) {
      result.landmarks.push_back(residual_of(camera, refined.pose, pair, sigma_px));
    }
  };
  // One that is far off would draw the pose along, and make others look bad: which are left out is asked anew each time.
  choose_near(camera, refined.pose, pairs);
  for (int round = 0; round < kMostRounds; ++round) {
    refined = refine(camera, pairs, sigma_px, refined);
    judge();
    if (!choose_fitting(result.landmarks, pairs)) break;
  }
  refined = refine(camera, pairs, sigma_px, refined);  // with those that are in use in the end
  judge();
  const auto unseen = [](const LandmarkResidual& l) { return l.used && std::isnan(l.sigmas); };
  if (std::ranges::any_of(result.landmarks, unseen)) refuse_image(image);
  result.image = image;
  result.camera_from_local = refined.pose * Rigid3{Eigen::Quaterniond::Identity(), -centre};
  result.pose_sigma = sigmas_of(refined.information);
  sum_up(result);
  return result;
}

void require_inside(const Sighting& sighting, const RigCamera& camera) {
  const Eigen::Vector2d& pixel = sighting.pixel;
  const ImageSize size = camera.camera.size;
  if (size.contains(pixel)) return;
  throw Error(ErrorKind::kBadInput,
              fmt::format("landmark '{}' is seen at pixel ({:.1f}, {:.1f}), outside of the {}x{} image of camera {}; "
                          "was it clicked in an image of another size?",
                          sighting.landmark, pixel.x(), pixel.y(), size.width, size.height, camera.name),
              sighting.image);
}

}  // namespace

void sum_up(SurveyImage& image) {
  double squares = 0.0, whitened = 0.0;
  int used = 0;
  for (const LandmarkResidual& landmark : image.landmarks) {
    if (!landmark.used) continue;
    squares += landmark.residual_px.squaredNorm();
    whitened += landmark.sigmas * landmark.sigmas;
    ++used;
  }
  const int freedom = 2 * used - (std::isnan(image.pose_sigma[3]) ? 3 : 6);
  image.rms_px = std::sqrt(squares / std::max(1, used));
  image.variance_factor = freedom > 0 ? whitened / freedom : std::numeric_limits<double>::quiet_NaN();
}

PlacedImages check_survey(const Calibration& calibration, const RigCamera& camera, const Survey& survey) {
  std::optional<ProjectionUncertainty> uncertainty;
  if (camera.evidence) uncertainty = projection_uncertainty(camera, calibration.covariance);
  std::map<std::string, std::vector<Pair>> images;
  for (const Sighting& sighting : survey.sightings) {
    if (!sighting.camera.empty() && sighting.camera != camera.name) continue;
    const auto landmark = std::ranges::find(survey.landmarks, sighting.landmark, &Landmark::name);
    if (landmark == survey.landmarks.end()) {
      throw Error(ErrorKind::kBadInput, "landmark '" + sighting.landmark + "' is not among the surveyed ones",
                  sighting.image);
    }
    require_inside(sighting, camera);
    images[sighting.image].push_back({&*landmark, sighting.pixel});
  }
  if (images.empty()) {
    throw Error(ErrorKind::kNotEnoughData, "none of the sightings is by camera " + camera.name + "; name another");
  }
  PlacedImages placed;
  for (const auto& [image, pairs] : images) {
    try {
      placed.images.push_back(image_of(camera.camera, image, pairs, survey.sighting_sigma_px, uncertainty));
      placed.images.back().camera = camera.name;
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::kNotEnoughData) throw;
      placed.not_placed.emplace_back(error.what());
    }
  }
  return placed;
}

}  // namespace raybundle
