// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "calibration_summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "raybundle/camera/camera.hpp"
#include "terminal.hpp"

namespace raybundle::apps {
namespace {

constexpr std::size_t kMostLines = 8;  // of one kind; report.json has them all

double degrees(double radians) { return radians * 180.0 / M_PI; }

// Angle off the axis of the last ray between the principal point and a point of the image border.
double reach_rad(const Camera& camera, const Eigen::Vector2d& border) {
  const Eigen::Vector2d centre(camera.cx(), camera.cy());
  const auto angle_at = [&](double way) -> std::optional<double> {
    const std::optional<Eigen::Vector3d> ray = ray_from_pixel(camera, centre + way * (border - centre));
    if (!ray) return std::nullopt;
    return std::atan2(ray->head<2>().norm(), ray->z());
  };
  if (const std::optional<double> angle = angle_at(1.0)) return *angle;
  double inside = 0.0, outside = 1.0;  // of the model's domain: the image circle of a fisheye ends within the image
  for (int i = 0; i < 30; ++i) (angle_at(0.5 * (inside + outside)) ? inside : outside) = 0.5 * (inside + outside);
  return angle_at(inside).value_or(0.0);
}

std::string field_text(const Camera& camera) {
  const double width = camera.size.width - 1, height = camera.size.height - 1;
  const double across = reach_rad(camera, {0, camera.cy()}) + reach_rad(camera, {width, camera.cy()});
  const double down = reach_rad(camera, {camera.cx(), 0}) + reach_rad(camera, {camera.cx(), height});
  return fmt::format("{:.0f}° x {:.0f}°", degrees(across), degrees(down));
}

std::string camera_table(const CalibrationProblem& problem, const CalibrationResult& result) {
  std::vector<std::vector<std::string>> rows{
      {"camera", "model", "views", "corners", "left out", "rms px", "median px", "focal px", "field"}};
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
      row.push_back(
          fmt::format("{:.2f} ± {:.2f}", found->camera.fx(), result.calibration.covariance.sigma(name + ".fx")));
      row.push_back(field_text(found->camera));
    }
    rows.push_back(row);
  }
  return text_table(rows);
}

std::string rig_lines(const CalibrationResult& result) {
  std::string text;
  const std::vector<RigCamera>& cameras = result.calibration.cameras;
  for (std::size_t c = 1; c < cameras.size(); ++c) {
    const Eigen::Vector3d centre = cameras[c].camera_from_rig.inverse().translation;
    const Covariance& covariance = result.calibration.covariance;
    double sigma2 = 0.0;  // of the length: the translation's sigma along itself, to first order
    const Eigen::Vector3d along = cameras[c].camera_from_rig.translation.normalized();
    for (int axis = 0; axis < 3; ++axis) {
      const char* axes[] = {"x", "y", "z"};
      const double sigma =
          covariance.sigma(fmt::format("{}.camera_from_rig.translation_{}", cameras[c].name, axes[axis]));
      sigma2 += along[axis] * along[axis] * sigma * sigma;
    }
    text += fmt::format("{} from {}: baseline {:.2f} ± {:.2f} mm, turned by {:.3f}°\n", cameras[c].name,
                        cameras[0].name, 1e3 * centre.norm(), 1e3 * std::sqrt(sigma2),
                        degrees(angle_between(cameras[c].camera_from_rig, Rigid3{})));
  }
  return text;
}

std::string shape_lines(const CalibrationResult& result) {
  std::string text;
  for (const CalibratedTarget& target : result.calibration.targets) {
    const BoardShape& shape = target.shape;
    if (shape.bend_x_m == 0 && shape.bend_y_m == 0 && shape.twist_m == 0) continue;
    text += fmt::format("{} is not flat: bend {:.2f} mm along x, {:.2f} mm along y, twist {:.2f} mm (estimated)\n",
                        target.target.name, 1e3 * shape.bend_x_m, 1e3 * shape.bend_y_m, 1e3 * shape.twist_m);
  }
  return text;
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
  std::string text = camera_table(problem, result) + rig_lines(result) + shape_lines(result);
  std::vector<std::string> aside;
  for (const SetAside& entry : result.set_aside) {
    const char* scope = entry.scope == SetAside::Scope::kExtrinsics ? " (not used to link the cameras)" : "";
    aside.push_back(fmt::format("{}{}: {}", view_name(problem, problem.views[entry.view]), scope, entry.reason));
  }
  add_limited(text, "set aside:", aside);
  std::vector<std::string> missing;
  for (const UnusedImage& image : unused) missing.push_back(fmt::format("{}: {}", image.image, image.reason));
  add_limited(text, fmt::format("{} images without a usable board:", unused.size()), missing);
  for (const std::string& warning : result.warnings) text += "warning: " + warning + "\n";
  return text;
}

}  // namespace raybundle::apps
