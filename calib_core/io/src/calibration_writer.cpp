// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>

#include "calibration_format.hpp"
#include "json_camera.hpp"
#include "json_laser.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "raybundle/scene/atomic_file.hpp"
#include "self_test.hpp"

namespace raybundle {
namespace {

[[noreturn]] void refuse(const std::string& message) {
  throw Error(ErrorKind::kBadInput, message + "; nothing was written", "calibration");
}

bool finite(const Rigid3& transform) {
  return transform.rotation.coeffs().allFinite() && transform.translation.allFinite();
}

void check(const Covariance& covariance) {
  const auto count = static_cast<Eigen::Index>(covariance.names.size());
  if (covariance.matrix.rows() != count || covariance.matrix.cols() != count) {
    refuse("the covariance matrix and its names differ in size");
  }
}

// What would keep the text from being made.
void check(const CalibrationFile& file) {
  const Calibration& calibration = file.calibration;
  if (calibration.cameras.empty()) refuse("there is no camera");
  check(calibration.covariance);
  if (calibration.covariance_by_frame) check(*calibration.covariance_by_frame);
  if (!file.summaries.empty() && file.summaries.size() != calibration.cameras.size()) {
    refuse("there are " + std::to_string(file.summaries.size()) + " residual summaries for " +
           std::to_string(calibration.cameras.size()) + " cameras");
  }
  std::set<std::string> names;
  for (const RigCamera& camera : calibration.cameras) {
    if (camera.name.empty()) refuse("a camera has no name; give each camera one");
    if (!names.insert(camera.name).second) refuse("two cameras are called " + camera.name + "; give each its own name");
    if (!camera.camera.parameters.allFinite() || !finite(camera.camera_from_rig)) {  // its self-test projects points
      refuse("camera " + camera.name + " holds a number that is not finite");
    }
  }
}

bool all_finite(const OrderedJson& json) {
  if (json.is_structured()) return std::ranges::all_of(json, all_finite);
  return !json.is_number_float() || std::isfinite(json.get<double>());
}

// What JSON has no word for would become null, which nobody could read back.
void require_finite(const OrderedJson& json) {
  for (const auto& [section, content] : json.items()) {
    if (!all_finite(content)) refuse("the section '" + section + "' holds a number that is not finite");
  }
}

// A file that cannot be read back is worse than none.
void require_readable(const std::string& text) {
  try {
    calibration_from_text(text, "calibration");
  } catch (const Error& error) {
    throw Error(ErrorKind::kBadInput, std::string(error.what()) + "; nothing was written");
  }
}

OrderedJson conventions() {
  return {
      {"pixel", "(0, 0) is the centre of the top-left pixel; u to the right, v down"},
      {"camera_axes", "x right, y down, z forward"},
      {"transform", "b_from_a: x_in_b = R(rotation_xyzw) x_in_a + translation_m"},
      {"rig_frame", "the frame of the first camera"},
      {"rotation_sigma", "a small rotation vector applied on the left of the rotation"},
      {"surface", "z = bend_x_m (1 - x^2) + bend_y_m (1 - y^2) + twist_m x y, x and y from -1 to 1 over the points"},
      {"beam_covariance",
       "two offsets of point_m [m] and two slopes of direction [rad], along the two vectors across "
       "the direction of Duff et al. 2017"}};
}

OrderedJson json_from_summary(const CameraSummary& summary) {
  return {{"rms_px", summary.rms_px},
          {"median_px", summary.median_px},
          {"views_used", summary.views_used},
          {"views_total", summary.views_total},
          {"corners_used", summary.corners_used},
          {"corners_outlier", summary.corners_outlier}};
}

// Six rows, of three rotations and three translations, one number for each parameter.
OrderedJson json_from_evidence(const CornerEvidence& evidence) {
  OrderedJson motion = OrderedJson::array();
  for (Eigen::Index i = 0; i < 6; ++i) motion.push_back(json_from_vector(evidence.implied_motion.row(i).transpose()));
  return {{"columns", evidence.columns},
          {"rows", evidence.rows},
          {"corners", evidence.corners},
          {"implied_motion", motion}};
}

OrderedJson json_from_camera(const CalibrationFile& file, std::size_t index) {
  const RigCamera& camera = file.calibration.cameras[index];
  OrderedJson json{{"name", camera.name},
                   {"model", model_name(camera.camera.model)},
                   {"width", camera.camera.size.width},
                   {"height", camera.camera.size.height}};
  add_estimates(camera, file.calibration.covariance, json);
  if (!file.summaries.empty()) json["residuals"] = json_from_summary(file.summaries[index]);
  if (camera.evidence) json["evidence"] = json_from_evidence(*camera.evidence);
  return json;
}

OrderedJson json_from_targets(const std::vector<CalibratedTarget>& targets) {
  OrderedJson json = OrderedJson::array();
  for (const CalibratedTarget& target : targets) {
    json.push_back({{"name", target.target.name},
                    {"shape", json_from_shape(target.shape)},
                    {"points", json_from_points(target.target)},
                    {"symmetries", json_from_symmetries(target.target)}});
  }
  return json;
}

// The lower triangle, row by row: a covariance is symmetric, so every number is written once.
OrderedJson json_from_covariance(const Covariance& covariance) {
  OrderedJson rows = OrderedJson::array();
  for (Eigen::Index i = 0; i < covariance.matrix.rows(); ++i) {
    rows.push_back(json_from_vector(covariance.matrix.row(i).head(i + 1).transpose()));
  }
  return {{"names", covariance.names}, {"lower_triangle", rows}};
}

OrderedJson json_from_self_test(const std::vector<RigCamera>& cameras) {
  OrderedJson json = OrderedJson::array();
  for (const RigCamera& camera : cameras) {
    for (const TestedPoint& test : self_tests_of(camera)) {
      json.push_back({{"camera", camera.name},
                      {"point_in_rig_m", json_from_vector(test.x_in_rig)},
                      {"ray_in_camera", json_from_vector(test.ray_in_camera)},
                      {"pixel", json_from_vector(test.pixel)}});
    }
  }
  return json;
}

}  // namespace

CalibrationFile calibration_file(const CalibrationProblem& problem, const CalibrationResult& result,
                                 const Provenance& provenance) {
  std::vector<CameraSummary> summaries;
  for (const RigCamera& camera : result.calibration.cameras) {
    const auto same = std::ranges::find(problem.cameras, camera.name, &ProblemCamera::name);
    summaries.push_back(result.cameras[same - problem.cameras.begin()]);
  }
  return {result.calibration, result.rms_px, result.variance_factor, summaries, provenance};
}

std::string text_from_calibration(const CalibrationFile& file) {
  check(file);
  OrderedJson cameras = OrderedJson::array();
  for (std::size_t i = 0; i < file.calibration.cameras.size(); ++i) cameras.push_back(json_from_camera(file, i));
  OrderedJson json{{"format", kCalibrationFormat},
                   {"version", kCalibrationVersion},
                   {"units", {{"length", "m"}, {"angle", "rad"}, {"image", "px"}}},
                   {"conventions", conventions()},
                   {"cameras", cameras},
                   {"targets", json_from_targets(file.calibration.targets)},
                   {"residuals", {{"rms_px", file.rms_px}, {"variance_factor", file.variance_factor}}},
                   {"covariance", json_from_covariance(file.calibration.covariance)},
                   {"self_test", json_from_self_test(file.calibration.cameras)},
                   {"provenance", json_from_provenance(file.provenance)}};
  if (file.calibration.covariance_by_frame) {
    json["covariance_by_frame"] = json_from_covariance(*file.calibration.covariance_by_frame);
  }
  if (file.calibration.laser) json["laser"] = json_from_pattern(*file.calibration.laser);
  require_finite(json);
  std::string text = pretty_text(json, {"self_test", "beams"});
  require_readable(text);
  return text;
}

void write_calibration(const std::filesystem::path& path, const CalibrationFile& file) {
  write_file_whole(path, text_from_calibration(file));
}

}  // namespace raybundle
