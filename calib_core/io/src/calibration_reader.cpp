// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <limits>
#include <set>
#include <string>

#include "calibration_format.hpp"
#include "json_laser.hpp"
#include "json_node.hpp"
#include "json_target.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "raybundle/scene/csv.hpp"
#include "raybundle/scene/suggestion.hpp"
#include "self_test.hpp"

namespace raybundle {
namespace {

constexpr int kMaxCount = std::numeric_limits<int>::max();

Camera camera_from(const JsonNode& node) {
  Camera camera{node.at("model").model(), node.image_size(), {}};
  const JsonNode parameters = node.at("parameters");
  const std::vector<std::string_view> names = parameter_names(camera.model);
  parameters.expect_keys({names.begin(), names.end()});
  camera.parameters.resize(static_cast<Eigen::Index>(names.size()));
  for (std::size_t k = 0; k < names.size(); ++k) {
    camera.parameters[static_cast<Eigen::Index>(k)] = parameters.at(names[k]).number();
  }
  return camera;
}

CornerEvidence evidence_from(const JsonNode& node, Eigen::Index parameters) {
  CornerEvidence evidence;
  evidence.columns = node.at("columns").whole_number(1, 4096);
  evidence.rows = node.at("rows").whole_number(1, 4096);
  const JsonNode corners = node.at("corners");
  corners.expect_array_size(static_cast<std::size_t>(evidence.columns) * evidence.rows);
  for (std::size_t i = 0; i < corners.array_size(); ++i) {
    evidence.corners.push_back(corners[i].whole_number(0, kMaxCount));
  }
  const JsonNode motion = node.at("implied_motion");
  motion.expect_array_size(6);
  evidence.implied_motion.resize(6, parameters);
  for (Eigen::Index i = 0; i < 6; ++i) {
    const JsonNode row = motion[static_cast<std::size_t>(i)];
    row.expect_array_size(static_cast<std::size_t>(parameters));
    for (Eigen::Index k = 0; k < parameters; ++k) {
      evidence.implied_motion(i, k) = row[static_cast<std::size_t>(k)].number();
    }
  }
  return evidence;
}

std::vector<RigCamera> cameras_from(const JsonNode& nodes) {
  if (nodes.array_size() == 0) nodes.fail("is empty; a calibration has at least one camera");
  std::vector<RigCamera> cameras;
  std::set<std::string> names;
  for (std::size_t i = 0; i < nodes.array_size(); ++i) {
    const JsonNode node = nodes[i];
    const JsonNode name = node.at("name");
    if (!names.insert(name.name()).second) name.fail(in_quotes(name.name()) + " stands twice; rename one camera");
    cameras.push_back({name.name(), camera_from(node), node.at("camera_from_rig").rigid3()});
    if (const auto evidence = node.find("evidence")) {
      cameras.back().evidence = evidence_from(*evidence, cameras.back().camera.parameters.size());
    }
  }
  return cameras;
}

CameraSummary summary_from(const JsonNode& node) {
  CameraSummary summary;
  summary.rms_px = node.at("rms_px").number();
  summary.median_px = node.at("median_px").number();
  summary.views_used = node.at("views_used").whole_number(0, kMaxCount);
  summary.views_total = node.at("views_total").whole_number(0, kMaxCount);
  summary.corners_used = node.at("corners_used").whole_number(0, kMaxCount);
  summary.corners_outlier = node.at("corners_outlier").whole_number(0, kMaxCount);
  return summary;
}

std::vector<CameraSummary> summaries_from(const JsonNode& cameras) {
  std::vector<CameraSummary> summaries;
  for (std::size_t i = 0; i < cameras.array_size(); ++i) {
    const JsonNode camera = cameras[i];
    if (const auto residuals = camera.find("residuals")) {
      summaries.push_back(summary_from(*residuals));
      if (summaries.size() != i + 1)
        residuals->fail("is there, but an earlier camera has none; add it to all or to none");
    } else if (!summaries.empty()) {
      camera.fail("has no residuals, but the first camera has; add them to all or to none");
    }
  }
  return summaries;
}

Covariance covariance_from(const JsonNode& node) {
  Covariance covariance;
  const JsonNode names = node.at("names");
  const JsonNode rows = node.at("lower_triangle");
  rows.expect_array_size(names.array_size());
  // Every row is checked before the matrix is made: a short file cannot ask for a large one.
  for (std::size_t i = 0; i < names.array_size(); ++i) {
    covariance.names.push_back(names[i].name());
    rows[i].expect_array_size(i + 1);
  }
  const auto size = static_cast<Eigen::Index>(names.array_size());
  covariance.matrix.resize(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const JsonNode row = rows[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j <= i; ++j) {
      covariance.matrix(i, j) = covariance.matrix(j, i) = row[static_cast<std::size_t>(j)].number();
    }
    if (covariance.matrix(i, i) < 0) row.fail("has a negative variance at its end; correct it");
  }
  return covariance;
}

// Whoever edits the parameters must not get by with taking the test out.
void require_self_tests(const JsonNode& tests, const std::set<std::string>& tested, const Calibration& calibration) {
  for (const RigCamera& camera : calibration.cameras) {
    if (tested.contains(camera.name) || self_tests_of(camera).empty()) continue;
    tests.fail("has nothing of camera " + in_quotes(camera.name) +
               ": the file was edited or made by another version; write it again");
  }
}

void replay_self_test(const JsonNode& tests, const Calibration& calibration) {
  std::set<std::string> tested;
  for (std::size_t i = 0; i < tests.array_size(); ++i) {
    const JsonNode test = tests[i];
    const JsonNode name = test.at("camera");
    const RigCamera* camera = nullptr;
    for (const RigCamera& candidate : calibration.cameras) {
      if (candidate.name == name.text()) camera = &candidate;
    }
    if (camera == nullptr) name.fail(in_quotes(name.text()) + " is not one of the cameras; correct it");
    tested.insert(camera->name);
    const Eigen::Vector2d expected = test.at("pixel").vector<2>();
    const Eigen::Vector3d rays[] = {camera->camera_from_rig * test.at("point_in_rig_m").vector<3>(),
                                    test.at("ray_in_camera").vector<3>()};
    for (const Eigen::Vector3d& ray : rays) {
      const auto pixel = ray.squaredNorm() > 0 ? pixel_from_ray(camera->camera, ray) : std::nullopt;
      if (pixel && (*pixel - expected).norm() <= kSelfTestTolerance_px) continue;
      const std::string found =
          pixel ? "differs by " + std::to_string((*pixel - expected).norm()) + " px" : "does not project";
      test.fail("of camera " + in_quotes(camera->name) + " " + found +
                ": the file was edited or made by another version; write it again");
    }
  }
  require_self_tests(tests, tested, calibration);
}

Provenance provenance_from(const JsonNode& node) {
  Provenance provenance;
  provenance.command = node.at("command").text();
  const JsonNode inputs = node.at("inputs");
  for (std::size_t i = 0; i < inputs.array_size(); ++i) {
    const JsonNode input = inputs[i];
    provenance.inputs.push_back({input.at("path").text(), input.at("sha256").text()});
  }
  const auto pairs_from = [](const JsonNode& list) {
    std::vector<std::pair<std::string, std::string>> pairs;
    for (std::size_t i = 0; i < list.array_size(); ++i) {
      const JsonNode pair = list[i];
      pairs.emplace_back(pair.at("name").text(), pair.at("value").text());
    }
    return pairs;
  };
  provenance.options = pairs_from(node.at("options"));
  provenance.versions = pairs_from(node.at("versions"));
  return provenance;
}

}  // namespace

CalibrationFile calibration_from_text(std::string_view text, const std::string& name) {
  const JsonDocument document = parse_json(text, name);
  const JsonNode root(document);
  expect_format(root, kCalibrationFormat, kCalibrationVersion);

  CalibrationFile file;
  const JsonNode cameras = root.at("cameras");
  file.calibration.cameras = cameras_from(cameras);
  file.summaries = summaries_from(cameras);
  file.calibration.targets = calibrated_targets_from(root.at("targets"));
  file.calibration.covariance = covariance_from(root.at("covariance"));
  if (const auto by_frame = root.find("covariance_by_frame")) {
    file.calibration.covariance_by_frame = covariance_from(*by_frame);
  }
  if (const auto laser = root.find("laser")) file.calibration.laser = pattern_from(*laser);
  const JsonNode residuals = root.at("residuals");
  file.rms_px = residuals.at("rms_px").number();
  file.variance_factor = residuals.at("variance_factor").number();
  file.provenance = provenance_from(root.at("provenance"));
  replay_self_test(root.at("self_test"), file.calibration);
  return file;
}

CalibrationFile read_calibration(const std::filesystem::path& path) {
  return calibration_from_text(text_of_file(path), path.string());
}

}  // namespace raybundle
