// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "calibration_summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "raybundle/calibrate/linking_frames.hpp"
#include "raybundle/camera/camera.hpp"
#include "raybundle/geometry/quantile.hpp"
#include "raybundle/scene/parameter_names.hpp"
#include "raybundle/uncertainty/frame_covariance.hpp"
#include "raybundle/uncertainty/verdict.hpp"
#include "survey_text.hpp"
#include "terminal.hpp"

namespace raybundle::apps {
namespace {

constexpr std::size_t kMostLines = 8;  // of one kind; report.json has them all

double degrees(double radians) { return radians * 180.0 / M_PI; }

// How far off the axis a camera has used corners: where the lens is known and not extrapolated.
std::string seen_text(const CalibrationProblem& problem, const CalibrationResult& result, int camera,
                      const Camera& model) {
  double farthest = 0.0;
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    if (problem.views[v].camera != camera) continue;
    for (std::size_t i = 0; i < result.views[v].fates.size(); ++i) {
      if (result.views[v].fates[i] != ObservationFate::kUsed) continue;
      const auto ray = ray_from_pixel(model, problem.views[v].observations[i].pixel);
      if (ray) farthest = std::max(farthest, std::atan2(ray->head<2>().norm(), ray->z()));
    }
  }
  return fmt::format("{:.0f}°", degrees(farthest));
}

double focal_sigma_by(const Covariance& covariance, const RigCamera& camera) {
  Eigen::VectorXd slopes(camera.camera.parameters.size());
  for (Eigen::Index k = 0; k < slopes.size(); ++k) {
    const double step = 1e-5 * std::max(1.0, std::abs(camera.camera.parameters[k]));
    Camera more = camera.camera, less = camera.camera;
    more.parameters[k] += step;
    less.parameters[k] -= step;
    slopes[k] = (focal_on_axis_px(more) - focal_on_axis_px(less)) / (2.0 * step);
  }
  return std::sqrt(std::max(0.0, slopes.dot(covariance.block(intrinsic_names(camera)) * slopes)));
}

// Pixels for each radian on the axis, which lenses of any model have: fx means something else in some.
std::string focal_text(const RigCamera& camera, const Calibration& calibration) {
  const double sigma =
      larger_sigma(calibration, [&](const Covariance& known) { return focal_sigma_by(known, camera); });
  return fmt::format("{:.2f} ± {:.2f}", focal_on_axis_px(camera.camera), sigma);
}

std::string camera_table(const CalibrationProblem& problem, const CalibrationResult& result) {
  std::vector<std::vector<std::string>> rows{
      {"camera", "model", "views", "corners", "left out", "rms px", "median px", "focal px", "seen to"}};
  for (std::size_t c = 0; c < problem.cameras.size(); ++c) {
    const CameraSummary& summary = result.cameras[c];
    const std::string& name = problem.cameras[c].name;
    const auto found = std::ranges::find(result.calibration.cameras, name, &RigCamera::name);
    std::vector<std::string> row{name, std::string(model_name(problem.cameras[c].model)),
                                 fmt::format("{}/{}", summary.views_used, summary.views_total),
                                 fmt::format("{}", summary.corners_used), fmt::format("{}", summary.corners_outlier)};
    if (found != result.calibration.cameras.end()) {
      row.push_back(fmt::format("{:.3f}", summary.rms_px));
      row.push_back(fmt::format("{:.3f}", summary.median_px));
      row.push_back(focal_text(*found, result.calibration));
      row.push_back(seen_text(problem, result, static_cast<int>(c), found->camera));
    }
    rows.push_back(row);
  }
  return text_table(rows);
}

// Beside a warning that the frames scatter by more, it matters which sigma is shown.
std::string sigma_line(const Calibration& calibration) {
  if (!calibration.covariance_by_frame) return {};
  return "±: one sigma, by the noise of the corners or by how the frames scatter, whichever is larger\n";
}

std::string rig_lines(const CalibrationResult& result) {
  std::string text;
  const std::vector<RigCamera>& cameras = result.calibration.cameras;
  for (std::size_t c = 1; c < cameras.size(); ++c) {
    const Eigen::Vector3d centre = cameras[c].camera_from_rig.inverse().translation;
    text += fmt::format("{} from {}: baseline {:.2f} ± {:.2f} mm, turned by {:.3f}°\n", cameras[c].name,
                        cameras[0].name, 1e3 * centre.norm(), 1e3 * baseline_sigma(cameras[c], result.calibration),
                        degrees(angle_between(cameras[c].camera_from_rig, Rigid3{})));
  }
  return text;
}

// How many of the frames that several cameras saw hold them together.
std::string link_line(const CalibrationProblem& problem, const CalibrationResult& result) {
  if (result.calibration.cameras.size() < 2) return {};
  const auto [shared, linking] = linking_frames(problem, result);
  return fmt::format("linked by {} of the {} frames in which several cameras saw the board\n", linking, shared);
}

std::string shape_lines(const CalibrationResult& result) {
  std::string text;
  for (const CalibratedTarget& target : result.calibration.targets) {
    const BoardShape& shape = target.shape;
    if (shape.sags().isZero(0)) continue;
    text += fmt::format("{} is bent, which is allowed for: {:.2f} mm along x, {:.2f} mm along y, twist {:.2f} mm\n",
                        target.target.name, 1e3 * shape.bend_x_m, 1e3 * shape.bend_y_m, 1e3 * shape.twist_m);
  }
  return text;
}

// Beams, dots, and what a dot's depth is worth.
std::string laser_lines(const CalibrationResult& result) {
  if (!result.laser || !result.calibration.laser) return {};
  const LaserSummary& laser = *result.laser;
  const LaserPattern& pattern = *result.calibration.laser;
  std::string text = fmt::format("laser: {} of {} beams from {} dots, rms {:.3f} px; {} outliers, {} unlabelled; {}\n",
                                 pattern.beams.size(), pattern.grid.size(), laser.dots_used, laser.rms_px,
                                 laser.dots_outlier, laser.dots_unlabelled, laser.label_origin);
  for (std::size_t d = 0; d < kStatedDepths_m.size(); ++d) {
    std::vector<double> sigmas, per_px;
    for (const LaserBeam& beam : pattern.beams) {
      if (std::isfinite(beam.depths[d].sigma_m)) sigmas.push_back(beam.depths[d].sigma_m);
      if (std::isfinite(beam.depths[d].per_px_m)) per_px.push_back(beam.depths[d].per_px_m);
    }
    if (sigmas.empty()) continue;
    text += fmt::format(
        "  at {:.1f} m {} beams are seen; depth ± {:.2f} mm by the calibration, {:.1f} mm for each px of a dot\n",
        kStatedDepths_m[d], sigmas.size(), 1e3 * median(sigmas), 1e3 * median(per_px));
  }
  if (!pattern.advice) return text;
  const LabelAdvice& advice = *pattern.advice;
  text += fmt::format("  labels: within {:.2f} px a dot alone tells its beam for {:.0f} % of depths",
                      advice.ambiguity.tolerance_px, 100 * advice.ambiguity.single_candidate_share);
  const bool turn_helps =
      advice.best_turn && advice.best_turn->single_candidate_share > advice.ambiguity.single_candidate_share + 0.01;
  if (turn_helps) {
    text += fmt::format("; with the grating turned by {:.0f}° it would be {:.0f} %",
                        degrees(advice.best_turn->turn_rad), 100 * advice.best_turn->single_candidate_share);
  }
  return text + "\n";
}

void add_limited(std::string& text, const std::string& head, const std::vector<std::string>& lines) {
  if (lines.empty()) return;
  text += head + "\n";
  for (std::size_t i = 0; i < std::min(lines.size(), kMostLines); ++i) text += "  " + lines[i] + "\n";
  if (lines.size() > kMostLines) text += fmt::format("  and {} more, see report.json\n", lines.size() - kMostLines);
}

}  // namespace

std::string summary_text(const CalibrationProblem& problem, const CalibrationResult& result,
                         const std::vector<UnusedImage>& unused) {
  std::string text = camera_table(problem, result) + rig_lines(result) + sigma_line(result.calibration) +
                     link_line(problem, result) + shape_lines(result) + laser_lines(result);
  if (result.survey) text += "surveyed landmarks:\n" + survey_lines(result.survey->images);
  std::vector<std::string> views, ties;
  for (const SetAside& entry : result.set_aside) {
    const TargetView& view = problem.views[entry.view];
    if (entry.scope == SetAside::Scope::kView) {
      views.push_back(fmt::format("{}: {}", view_name(problem, view), entry.reason));
      continue;
    }
    const std::string line = fmt::format("frame {}: {}", problem.frames[view.frame], entry.reason);
    if (std::ranges::find(ties, line) == ties.end()) ties.push_back(line);  // one for each of its views
  }
  add_limited(text, "views set aside:", views);
  add_limited(text,
              "frames that calibrate their cameras but do not link them, because the board seems to have moved:", ties);
  std::map<std::string, int> count_of;
  std::vector<std::string> misses, missing;
  for (const UnusedImage& image : unused) {
    const std::string line = fmt::format("{}: {}", image.image, image.reason);
    if (++count_of[line] == 1) misses.push_back(line);
  }
  for (const std::string& line : misses) {
    missing.push_back(count_of[line] > 1 ? fmt::format("{} ({} frames)", line, count_of[line]) : line);
  }
  add_limited(text, fmt::format("{} image{} left out:", unused.size(), unused.size() == 1 ? "" : "s"), missing);
  for (const std::string& warning : result.warnings) text += "warning: " + warning + "\n";
  return text;
}

}  // namespace raybundle::apps
