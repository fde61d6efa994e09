// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "findings.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "motion_findings.hpp"
#include "raybundle/uncertainty/drift.hpp"
#include "raybundle/uncertainty/frame_covariance.hpp"
#include "raybundle/uncertainty/residual_bias.hpp"
#include "sensitivity.hpp"

namespace raybundle {
namespace {

constexpr double kReachedShare = 0.9;    // of the image's half field that corners should reach
constexpr double kEnoughTilt = 0.35;     // [rad] 20°: below, focal length and distance look alike
constexpr double kEnoughDepth = 1.5;     // farthest over nearest board
constexpr double kWeakDirection = 1000;  // times worse than the parameters one at a time
constexpr double kDriftSigmas = 5.0;
constexpr double kFewRayless = 0.01;  // of the image
constexpr double kSquare = 0.004;     // relative difference of fx and fy: pixels of sensors are square to a thousandth
constexpr double kStretchSigmas = 5.0;
constexpr double kRadialSigmas = 4.0;  // lenses that fit stay below 2, those that plainly do not reach 4 to 10
constexpr double kRadialShare = 0.2;   // of the rms: what is less is no plain misfit, however many corners show it

double degrees(double radians) { return radians * 180.0 / M_PI; }

// Residuals that point outwards at some angles and inwards at others are what a model with too few parameters leaves.
std::optional<Finding> lens_finding(const ResidualBias& bias, const RigCamera& camera) {
  const int strongest = bias.strongest_band();
  if (strongest < 0) return std::nullopt;
  const ResidualGroup& band = bias.bands[static_cast<std::size_t>(strongest)];
  const double outwards = band.mean_px.x();
  const bool good = band.first_sigmas() < kRadialSigmas || std::abs(outwards) < kRadialShare * bias.rms_px;
  if (good) return Finding{camera.name, "lens", true, "the residuals have no direction outwards or inwards", {}};
  return Finding{
      camera.name, "lens", false,
      fmt::format("the residuals point {} by {:.2f} px from {:.0f}° to {:.0f}° off the axis, {:.0f} sigmas: "
                  "{} does not fit this lens",
                  outwards > 0 ? "outwards" : "inwards", std::abs(outwards), degrees(strongest * bias.band_rad),
                  degrees((strongest + 1) * bias.band_rad), band.first_sigmas(), model_name(camera.camera.model)),
      "before anything else choose a model with more parameters, or for a wider field"};
}

Finding image_finding(const CameraCoverage& seen) {
  Finding finding{seen.camera,
                  "image",
                  seen.empty_regions.empty(),
                  fmt::format("corners were seen in {:.0f} % of the image", 100 * seen.image_share),
                  {}};
  if (finding.good) return finding;
  finding.text += ", hardly any at " + regions_in_words(seen.empty_regions);
  finding.advice = "hold the board there in three more views, tilted by about 45°, unless the lens leaves it black";
  return finding;
}

Finding angle_finding(const CameraCoverage& seen) {
  const bool good = seen.seen_to_rad >= kReachedShare * seen.reach_rad;
  return {seen.camera, "angle", good,
          fmt::format("corners reach {:.0f}° off the axis, the edges of the image {:.0f}°", degrees(seen.seen_to_rad),
                      degrees(seen.reach_rad)),
          good ? "" : "beyond, the lens is extrapolated: hold the board nearer to the edges, or do not use them"};
}

// A lens whose model folds or has a pole ends there, which is no harm where the image is black.
std::optional<Finding> field_finding(const CameraCoverage& seen) {
  if (seen.rayless_share < kFewRayless) return std::nullopt;
  return Finding{seen.camera, "field", false,
                 fmt::format("the model has no ray for {:.0f} % of the image", 100 * seen.rayless_share),
                 "unless the lens leaves it black there, hold the board there, too, or choose another model"};
}

// A board that is longer in one direction than it is said to be fits no worse where it is always held upright.
std::optional<Finding> square_finding(const RigCamera& camera, const Calibration& calibration) {
  const double fx = camera.camera.fx(), fy = camera.camera.fy(), stretch = fx / fy - 1.0;
  const Eigen::RowVector2d by_focals(1.0 / fy, -fx / (fy * fy));
  const std::vector<std::string> focals{camera.name + ".fx", camera.name + ".fy"};
  const double sigma = larger_sigma(calibration, [&](const Covariance& known) {
    return std::sqrt(std::max(0.0, (by_focals * known.block(focals) * by_focals.transpose()).value()));
  });
  if (!(sigma > 0.0)) return std::nullopt;
  const double sigmas = std::abs(stretch) / sigma;
  const bool good = std::abs(stretch) < kSquare || sigmas < kStretchSigmas;
  return Finding{camera.name, "square", good,
                 fmt::format("fx is {:.2f} % {} than fy, {:.1f} sigmas", 100 * std::abs(stretch),
                             stretch > 0 ? "more" : "less", sigmas),
                 good ? ""
                      : "few sensors have such pixels: measure the printed board in both directions; if they differ, "
                        "print it again in true scale, or say row_step_m where it is one of asymmetric circles"};
}

Finding tilt_finding(const CameraCoverage& seen) {
  const bool good = seen.largest_tilt_rad >= kEnoughTilt;
  return {seen.camera, "tilt", good,
          fmt::format("the boards are tilted by {:.0f}° in the median, a tenth of them by more than {:.0f}°",
                      degrees(seen.usual_tilt_rad), degrees(seen.largest_tilt_rad)),
          good ? "" : "tilt the board by 30° to 50° in several directions: facing boards tell no focal length"};
}

Finding distance_finding(const CameraCoverage& seen) {
  const bool good = seen.farthest_m >= kEnoughDepth * seen.nearest_m;
  return {seen.camera, "distance", good,
          fmt::format("the boards were {:.2f} to {:.2f} m away", seen.nearest_m, seen.farthest_m),
          good ? "" : "hold the board nearer and farther, too, out to where the camera will be used"};
}

std::string group_of(const std::string& parameter) {
  if (parameter == "fx" || parameter == "fy") return "focal length";
  if (parameter == "cx" || parameter == "cy") return "principal point";
  return "distortion";
}

// The weakest direction of a camera's parameters, each in units of what it would be known to alone, with the words for
// the kinds of parameters that make up at least a tenth of it. What single kinds are confused with are the boards.
std::string direction_in_words(const std::vector<std::string>& parameters, const Eigen::VectorXd& direction) {
  std::string kinds;
  int count = 0;
  for (const char* kind : {"focal length", "principal point", "distortion"}) {
    double share = 0.0;
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      if (group_of(parameters[i]) == kind) share += std::pow(direction[static_cast<Eigen::Index>(i)], 2);
    }
    if (share < 0.1) continue;
    kinds += (kinds.empty() ? "" : " against ") + std::string(kind);
    ++count;
  }
  if (count > 1) return kinds;
  if (kinds == "focal length") return kinds + " against the distance of the boards";
  if (kinds == "principal point") return kinds + " against the direction of the boards";
  return "the terms of the distortion against each other";
}

std::optional<Finding> parameters_finding(const RigCamera& camera, const Covariance& covariance) {
  const std::vector<std::string> names = intrinsic_names(camera);
  std::vector<std::string> parameters;
  std::vector<Eigen::Index> places;
  for (const int place : covariance.places_of(names)) {
    if (place < 0) continue;
    places.push_back(place);
    parameters.push_back(covariance.names[place].substr(camera.name.size() + 1));
  }
  if (places.size() < 2) return std::nullopt;
  const Eigen::MatrixXd known = covariance.matrix(places, places);
  const Eigen::VectorXd scale = known.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd correlation = scale.asDiagonal() * known * scale.asDiagonal();
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(correlation);
  const Eigen::VectorXd values = eigen.eigenvalues().cwiseMax(1e-15);
  // Of the information, its columns scaled to one: what each parameter would be known to if it were alone.
  Eigen::MatrixXd information =
      eigen.eigenvectors() * values.cwiseInverse().asDiagonal() * eigen.eigenvectors().transpose();
  const Eigen::VectorXd alone = information.diagonal().cwiseSqrt().cwiseInverse();
  eigen.compute(alone.asDiagonal() * information * alone.asDiagonal());
  const double weakest = std::max(eigen.eigenvalues()[0], 1e-15);
  const double inflation = 1.0 / std::sqrt(weakest), condition = eigen.eigenvalues().tail<1>()[0] / weakest;
  const bool good = inflation < kWeakDirection;
  return Finding{
      camera.name, "parameters", good,
      fmt::format("what it tells apart least is {}: {:.0f} times worse than each alone, condition number {:.1e}",
                  direction_in_words(parameters, eigen.eigenvectors().col(0)), inflation, condition),
      good ? "" : "tilt the board more, near and far, or choose a model with fewer parameters"};
}

// The principal point's, which a touched lens moves first. What is less than the corners' noise does no harm. Too few
// frames to tell how much those of a touched lens would scatter anyway tell nothing.
std::optional<Finding> drift_finding(const RigCamera& camera, double rms_px, const std::vector<Drift>& drifts,
                                     const Calibration& calibration) {
  if (!calibration.covariance_by_frame) return std::nullopt;
  double moved2 = 0.0, sigmas = 0.0;
  bool any = false;
  for (const Drift& drift : drifts) {
    if (drift.name != camera.name + ".cx" && drift.name != camera.name + ".cy") continue;
    any = true;
    moved2 += drift.change * drift.change;
    // Where corners of a frame err together, halves of the frames differ by more than the corners' noise.
    const double plain = calibration.covariance.sigma(drift.name);
    const double by_frame = calibration.covariance_by_frame->sigma(drift.name);
    sigmas = std::max(sigmas, std::abs(drift.change) / (drift.sigma * std::max(1.0, by_frame / plain)));
  }
  if (!any) return std::nullopt;
  const double moved = std::sqrt(moved2);
  const bool good = sigmas < kDriftSigmas || moved < rms_px;
  return Finding{camera.name, "drift", good,
                 fmt::format("from the first half of the frames to the second the principal point moves by {:.2f} px, "
                             "{:.1f} of its sigmas",
                             moved, sigmas),
                 good ? "" : "was the lens or its mount touched, or did it warm up? Then calibrate from one half only"};
}

// A bend makes up for much of a lens that does not fit: then it says nothing about the board.
std::optional<Finding> shape_finding(const CalibratedTarget& target, bool lenses_fit) {
  const BoardShape& shape = target.shape;
  const double largest = shape.sags().cwiseAbs().maxCoeff();
  if (largest == 0.0) return std::nullopt;
  double width = 0.0;
  for (const TargetPoint& point : target.target.points) {
    width = std::max(width, (point.x_in_target - target.target.points.front().x_in_target).norm());
  }
  constexpr double kFlatEnough = 0.005;  // of the diagonal; beyond, bend and twist do not describe a sheet any more
  const bool good = largest < kFlatEnough * width;
  if (!good && !lenses_fit) {
    return Finding{target.target.name, "shape", false,
                   fmt::format("it would be bent by up to {:.2f} mm, which may be the lens instead", 1e3 * largest),
                   "look at it again when the lens fits"};
  }
  return Finding{target.target.name, "shape", good,
                 fmt::format("it is bent by up to {:.2f} mm, which the solve allows for", 1e3 * largest),
                 good ? "" : "glue it to something stiff"};
}

}  // namespace

std::vector<Finding> findings(const CalibrationProblem& problem, const CalibrationResult& result,
                              const std::vector<CameraCoverage>& seen) {
  std::vector<Finding> all;
  const std::vector<Drift> drifts = drift_between_halves(problem, result);
  bool lenses_fit = true;
  for (std::size_t c = 0; c < seen.size(); ++c) {
    const RigCamera& camera = result.calibration.cameras[c];
    const auto named = std::ranges::find(problem.cameras, camera.name, &ProblemCamera::name);
    const auto index = static_cast<int>(named - problem.cameras.begin());
    const double rms_px = result.cameras[index].rms_px;
    if (const auto finding = lens_finding(residual_bias(problem, result, index, camera.camera), camera)) {
      lenses_fit = lenses_fit && finding->good;
      all.push_back(*finding);
    }
    all.push_back(image_finding(seen[c]));
    if (const auto finding = field_finding(seen[c])) all.push_back(*finding);
    all.push_back(angle_finding(seen[c]));
    if (const auto finding = square_finding(camera, result.calibration)) all.push_back(*finding);
    all.push_back(tilt_finding(seen[c]));
    all.push_back(distance_finding(seen[c]));
    if (const auto finding = parameters_finding(camera, result.calibration.covariance)) all.push_back(*finding);
    if (const auto finding = drift_finding(camera, rms_px, drifts, result.calibration)) all.push_back(*finding);
    if (const auto finding = shutter_finding(problem, result, index)) all.push_back(*finding);
  }
  if (const auto finding = sync_finding(problem, result)) all.push_back(*finding);
  if (const auto finding = repetition_finding(problem, result)) all.push_back(*finding);
  for (const CalibratedTarget& target : result.calibration.targets) {
    if (const auto finding = shape_finding(target, lenses_fit)) all.push_back(*finding);
  }
  return all;
}

}  // namespace raybundle
