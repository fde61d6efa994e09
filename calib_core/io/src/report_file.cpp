// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/io/report_file.hpp"

#include <algorithm>
#include <limits>

#include "json_camera.hpp"
#include "json_laser.hpp"
#include "raybundle/scene/atomic_file.hpp"

namespace raybundle {
namespace {

// In the order of the enumerations.
constexpr const char* kFates[] = {"used", "outlier", "unprojectable", "view_set_aside", "unlabelled"};
constexpr const char* kTerminations[] = {"converged", "iteration_limit", "blocked", "failed"};
constexpr const char* kScopes[] = {"view", "extrinsics"};

OrderedJson json_from_cameras(const CalibrationProblem& problem, const CalibrationResult& result) {
  OrderedJson json = OrderedJson::array();
  for (std::size_t i = 0; i < problem.cameras.size(); ++i) {
    const ProblemCamera& camera = problem.cameras[i];
    const CameraSummary summary = i < result.cameras.size() ? result.cameras[i] : CameraSummary{};
    OrderedJson entry{{"name", camera.name},
                      {"model", model_name(camera.model)},
                      {"width", camera.size.width},
                      {"height", camera.size.height},
                      {"rms_px", summary.rms_px},
                      {"median_px", summary.median_px},
                      {"views_used", summary.views_used},
                      {"views_total", summary.views_total},
                      {"sigma_scale", summary.sigma_scale},
                      {"corners_used", summary.corners_used},
                      {"corners_outlier", summary.corners_outlier}};
    const auto found = std::ranges::find(result.calibration.cameras, camera.name, &RigCamera::name);
    if (found != result.calibration.cameras.end()) add_estimates(*found, result.calibration.covariance, entry);
    json.push_back(entry);
  }
  return json;
}

OrderedJson json_from_targets(const CalibrationProblem& problem, const CalibrationResult& result) {
  OrderedJson json = OrderedJson::array();
  for (std::size_t i = 0; i < problem.targets.size(); ++i) {
    OrderedJson target{{"name", problem.targets[i].name}, {"points", json_from_points(problem.targets[i])}};
    if (i < result.calibration.targets.size()) {
      target["shape"] = json_from_shape(result.calibration.targets[i].shape);
      target["shape_sigmas"] = json_from_shape_sigmas(result.calibration.covariance, problem.targets[i].name);
    }
    json.push_back(target);
  }
  return json;
}

OrderedJson json_from_set_aside(const CalibrationProblem& problem, const CalibrationResult& result,
                                const ReportExtra& extra) {
  OrderedJson json = OrderedJson::array();
  for (const SetAside& set_aside : result.set_aside) {
    const TargetView& view = problem.views[set_aside.view];
    json.push_back({{"camera", problem.cameras[view.camera].name},
                    {"frame", problem.frames[view.frame]},
                    {"target", view.target},
                    {"image", view.image},
                    {"scope", kScopes[static_cast<int>(set_aside.scope)]},
                    {"reason", set_aside.reason}});
  }
  for (const UnusedImage& unused : extra.unused_images) {
    json.push_back({{"camera", unused.camera},
                    {"frame", unused.frame},
                    {"image", unused.image},
                    {"scope", "image"},
                    {"reason", unused.reason}});
  }
  return json;
}

// By how much each sigma grows when the frames are asked instead of the corners.
OrderedJson json_from_frame_scatter(const Calibration& calibration) {
  OrderedJson json = OrderedJson::object();
  for (const std::string& name : calibration.covariance.names) {
    const double sigma = calibration.covariance.sigma(name);
    if (sigma > 0) json[name] = calibration.covariance_by_frame->sigma(name) / sigma;
  }
  return json;
}

OrderedJson json_from_stages(const std::vector<StageTime>& stages) {
  OrderedJson json = OrderedJson::array();
  for (const StageTime& stage : stages) json.push_back({{"name", stage.name}, {"seconds", stage.seconds}});
  return json;
}

OrderedJson json_from_poses(const CalibrationProblem& problem, const std::vector<BoardPose>& poses) {
  OrderedJson json = OrderedJson::array();
  for (const BoardPose& pose : poses) {
    json.push_back({{"frame", problem.frames[pose.frame]},
                    {"target", pose.target},
                    {"rig_from_target", json_from_rigid3(pose.rig_from_target)}});
  }
  return json;
}

// One row for each dot of a view: pixel, row and column of its beam or null, residual, fate.
OrderedJson json_from_dots(const LaserGrid& grid, const TargetView& view, const ViewResult& result) {
  OrderedJson rows = OrderedJson::array();
  for (std::size_t i = 0; i < std::min(view.dots.size(), result.dot_fates.size()); ++i) {
    const int beam = result.beam_of_dot[i];
    OrderedJson row = OrderedJson::array({view.dots[i].pixel.x(), view.dots[i].pixel.y()});
    row.push_back(beam < 0 ? OrderedJson() : OrderedJson(grid.row(beam)));
    row.push_back(beam < 0 ? OrderedJson() : OrderedJson(grid.column(beam)));
    for (int k = 0; k < 2; ++k) row.push_back(result.dot_residuals_px[i][k]);
    row.push_back(static_cast<int>(result.dot_fates[i]));
    rows.push_back(row);
  }
  return rows;
}

OrderedJson json_from_laser_summary(const LaserSummary& laser) {
  OrderedJson parameters = OrderedJson::array();
  for (const DraggedParameter& parameter : laser.parameters) {
    parameters.push_back({{"name", parameter.name},
                          {"without_dots", parameter.without},
                          {"with_dots", parameter.with},
                          {"sigma_without_dots", parameter.sigma_without}});
  }
  return {{"dots_used", laser.dots_used},
          {"dots_outlier", laser.dots_outlier},
          {"dots_unlabelled", laser.dots_unlabelled},
          {"dots_unused", laser.dots_unused},
          {"rms_px", laser.rms_px},
          {"sigma_scale", laser.sigma_scale},
          {"grating_rms_rad", laser.grating_rms_rad},
          {"beams_with_prior", laser.beams_with_prior},
          {"label_origin", laser.label_origin},
          {"drag_sigmas", drag_sigmas(laser.parameters)},
          {"parameters", parameters}};
}

// One row for each observation; a residual that does not exist becomes null.
OrderedJson json_from_view(const CalibrationProblem& problem, const TargetView& view, const ViewResult& result) {
  OrderedJson rows = OrderedJson::array();
  for (std::size_t i = 0; i < view.observations.size(); ++i) {
    const Observation& observation = view.observations[i];
    const bool known = i < result.residuals_px.size() && i < result.fates.size();
    const Eigen::Vector2d residual =
        known ? result.residuals_px[i] : Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
    const ObservationFate fate = known ? result.fates[i] : ObservationFate::kViewSetAside;
    rows.push_back({observation.point_id, observation.pixel.x(), observation.pixel.y(), observation.sigma_px,
                    residual.x(), residual.y(), static_cast<int>(fate)});
  }
  OrderedJson json{{"camera", problem.cameras[view.camera].name},
                   {"frame", problem.frames[view.frame]},
                   {"target", view.target},
                   {"image", view.image},
                   {"pose", result.pose},
                   {"rms_px", result.rms_px}};
  json["observations"] = rows;
  if (!view.dots.empty() && problem.laser) json["dots"] = json_from_dots(problem.laser->grid, view, result);
  return json;
}

OrderedJson json_from_lens_priors(const CalibrationResult& result) {
  OrderedJson json = OrderedJson::array();
  for (const ParameterRule& prior : result.lens_priors) json.push_back(prior.pattern);
  return json;
}

LongArray views_of(const CalibrationProblem& problem, const CalibrationResult& result) {
  return {"views", problem.views.size(), [&](std::size_t i) {
            const ViewResult none;
            return json_from_view(problem, problem.views[i], i < result.views.size() ? result.views[i] : none);
          }};
}

}  // namespace

std::string text_from_report(const CalibrationProblem& problem, const CalibrationResult& result,
                             const ReportExtra& extra) {
  OrderedJson json{
      {"format", "raybundle report"},
      {"version", 1},
      {"rms_px", result.rms_px},
      {"variance_factor", result.variance_factor},
      {"termination", kTerminations[static_cast<int>(result.termination)]},
      {"iterations", result.iterations},
      {"gauge", result.gauge},
      {"outlier_rule", result.outlier_rule},
      {"lens_priors", json_from_lens_priors(result)},
      {"warnings", result.warnings},
      {"cameras", json_from_cameras(problem, result)},
      {"set_aside", json_from_set_aside(problem, result, extra)},
      {"stages", json_from_stages(result.stages)},
      {"targets", json_from_targets(problem, result)},
      {"poses", json_from_poses(problem, result.poses)},
      {"fates", kFates},
      {"observation_columns", {"point_id", "u_px", "v_px", "sigma_px", "residual_u_px", "residual_v_px", "fate"}},
      {"views", OrderedJson::array()},
      {"provenance", json_from_provenance(extra.provenance)}};
  if (result.calibration.covariance_by_frame) {
    json["sigma_ratio_by_frame"] = json_from_frame_scatter(result.calibration);
  }
  if (result.laser) {
    json["laser"] = json_from_laser_summary(*result.laser);
    if (result.calibration.laser) json["laser"].update(json_from_pattern(*result.calibration.laser));
    json["dot_columns"] = {"u_px", "v_px", "row", "column", "residual_u_px", "residual_v_px", "fate"};
  }
  for (const ReportSection& section : extra.sections) json[section.name] = OrderedJson::parse(section.json);
  const LongArray views = views_of(problem, result);
  return pretty_text(json, {"beams"}, &views);
}

void write_report(const std::filesystem::path& path, const CalibrationProblem& problem, const CalibrationResult& result,
                  const ReportExtra& extra) {
  write_file_whole(path, text_from_report(problem, result, extra));
}

}  // namespace raybundle
