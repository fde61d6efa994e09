// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "stereo_flags.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "number_flags.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/quantile.hpp"
#include "raybundle/io/calibration_file.hpp"

namespace raybundle::apps {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kNearBaselines = 4.0;  // what is nearer is rarely of interest to a pair, and costs time
constexpr int kMostDisparities = 1000;

// The disparity at the middle of the image of a point at a distance.
double disparity_at(const Rectification& pair, double distance_m) {
  return disparity_from_distance(pair.camera, pair.baseline_m, pair.camera.centre_px.x(), distance_m);
}

std::vector<std::string> cost_names() {
  std::vector<std::string> names;
  for (const MatchCost cost : kMatchCosts) names.emplace_back(match_cost_name(cost));
  return names;
}

}  // namespace

void declare_rectify_flags(CLI::App& verb, RectifyFlags& flags) {
  flags.options = {
      verb.add_option("--left", flags.left, "name of the left camera; of two cameras the first one unless said")
          ->type_name("NAME"),
      verb.add_option("--right", flags.right, "name of the right camera; of two cameras the second one unless said")
          ->type_name("NAME"),
      verb.add_option("--projection", flags.projection, "pinhole or equirectangular; the advised one unless said")
          ->check(CLI::IsMember({"pinhole", "equirectangular"})),
      verb.add_option("--width", flags.width_px, "of the rectified images [px]; as dense as the cameras unless said")
          ->check(CLI::Range(16, 1 << 14)),
      verb.add_option("--height", flags.height_px, "of the rectified images [px]")->check(CLI::Range(16, 1 << 14)),
      verb.add_option("--field", flags.field_deg,
                      "of view to keep along the baseline, up to 180, and across it [deg]; all unless said")
          ->expected(2)
          ->check(CLI::Range(1.0, 360.0))};
}

RectifyOptions rectify_options(const RectifyFlags& flags) {
  RectifyOptions options;
  options.projection = rectified_projection_named(flags.projection);
  options.width_px = flags.width_px;
  options.height_px = flags.height_px;
  if (!flags.field_deg.empty()) {
    options.field_x_rad = flags.field_deg[0] * kDegree;
    options.field_y_rad = flags.field_deg[1] * kDegree;
  }
  return options;
}

CameraPair camera_pair(const Calibration& calibration, const RectifyFlags& flags) {
  if (calibration.cameras.size() < 2) {
    throw Error(ErrorKind::kBadInput, fmt::format("a stereo pair needs two cameras, but the calibration holds {}",
                                                  calibration.cameras.size()));
  }
  if (calibration.cameras.size() > 2 && (flags.left.empty() || flags.right.empty())) {
    throw Error(ErrorKind::kBadInput,
                fmt::format("which two of the {} cameras? Say --left NAME --right NAME", calibration.cameras.size()));
  }
  if (!flags.left.empty() && flags.left == flags.right) {
    throw Error(ErrorKind::kBadInput, "--left and --right are both '" + flags.left + "'; name two cameras");
  }
  const auto other_than = [&](const std::string& name) -> const RigCamera& {
    return calibration.cameras[calibration.cameras[0].name == name ? 1 : 0];
  };
  if (!flags.left.empty() && !flags.right.empty()) {
    return {camera_named(calibration, flags.left), camera_named(calibration, flags.right)};
  }
  if (!flags.left.empty()) return {camera_named(calibration, flags.left), other_than(flags.left)};
  if (!flags.right.empty()) return {other_than(flags.right), camera_named(calibration, flags.right)};
  return {calibration.cameras[0], calibration.cameras[1]};
}

std::string rectification_text(const Rectification& pair) {
  std::string text = fmt::format(
      "rectified: {}, {}x{} px, {:.0f}° x {:.0f}°, baseline {:.2f} mm; it shows {:.1f} % of the left and {:.1f} % of "
      "the right field",
      rectified_projection_name(pair.camera.projection), pair.camera.size.width, pair.camera.size.height,
      pair.field_x_rad / kDegree, pair.field_y_rad / kDegree, 1e3 * pair.baseline_m, 100 * pair.kept_left,
      100 * pair.kept_right);
  if (pair.rim_over_centre > 2)
    text += fmt::format("; its rim is sampled {:.1f} times as densely", pair.rim_over_centre);
  return text;
}

void declare_stereo_flags(CLI::App& verb, StereoFlags& flags) {
  declare_rectify_flags(verb, flags.rectify);
  verb.add_option("--near", flags.near_m, "nearest distance [m]; four baselines unless said")->check(above_zero);
  verb.add_option("--disparities", flags.disparities, "how many to search instead [px]")
      ->check(CLI::Range(1, kMostDisparities));
  verb.add_option("--least-disparity", flags.least_disparity, "where to begin [px]; matches lie beyond it")
      ->check(CLI::Range(0, 1 << 14));
  verb.add_option("--cost", flags.cost, "how unlike windows are: census, ssd or zncc")
      ->transform(CLI::IsMember(cost_names()))
      ->capture_default_str();
  verb.add_option("--window", flags.window_px, "side of the square that costs are averaged over, odd [px]")
      ->check(CLI::Range(1, 15))
      ->capture_default_str();
  verb.add_option("--paths", flags.paths, "that costs are gathered along: 3, 4 (slower), or 0")
      ->check(CLI::IsMember({0, 3, 4}))
      ->capture_default_str();
  verb.add_option("--coarse", flags.coarse_levels, "halved sizes to begin with; beyond 250 disparities unless said")
      ->check(CLI::Range(0, 6));
  verb.add_option("--uniqueness", flags.uniqueness, "how much better than the second best a match must be")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  verb.add_option("--strength", flags.strength, "largest cost of a match, as a share of the largest there is")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  verb.add_option("--peak", flags.peak, "least rise of the cost beside a match, as a share of the largest there is")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  verb.add_option("--least-region", flags.least_region_px, "regions with fewer pixels are left out")
      ->check(CLI::Range(0, 1 << 24))
      ->capture_default_str();
  verb.add_option("--least-matched", flags.least_matched_percent,
                  "gate for each pair: share of what both cameras show that is matched [%]")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
}

StereoSetup stereo_setup(const std::string& calibration_path, const StereoFlags& flags, bool with_dots) {
  const CalibrationFile file = read_calibration(calibration_path);
  const auto [left, right] = camera_pair(file.calibration, flags.rectify);
  StereoOptions options;
  options.rectify = rectify_options(flags.rectify);
  options.match.uniqueness = flags.uniqueness;
  options.match.strength = flags.strength;
  options.match.peak = flags.peak;
  options.match.least_region_px = flags.least_region_px;
  options.match.least_disparity = flags.least_disparity;
  options.match.cost = match_cost_named(flags.cost).value_or(options.match.cost);
  options.match.window_px = flags.window_px;
  options.match.paths = flags.paths;
  options.least_matched = flags.least_matched_percent / 100.0;
  if (with_dots && file.calibration.laser) {
    options.dots = DotFusionOptions{.most_dots = static_cast<int>(file.calibration.laser->beams.size())};
  }
  const Rectification pair = rectify(left, right, options.rectify);
  const double near_m = flags.near_m > 0 ? flags.near_m : kNearBaselines * pair.baseline_m;
  const double wanted = std::ceil(disparity_at(pair, near_m)) + 2 - flags.least_disparity;
  if (flags.near_m > 0 && flags.disparities == 0 && (wanted < 1 || wanted > kMostDisparities)) {
    throw Error(
        ErrorKind::kBadInput,
        fmt::format("--near {:g} with --least-disparity {} is a search of {} disparities, which must be 1 to {}; "
                    "take another distance, or rectify to a smaller --width",
                    flags.near_m, flags.least_disparity, wanted, kMostDisparities));
  }
  options.match.disparities =
      flags.disparities > 0 ? flags.disparities : static_cast<int>(std::clamp(wanted, 1.0, 1.0 * kMostDisparities));
  options.match.mask = census_for(options.match.disparities);
  options.match.coarse_levels =
      flags.coarse_levels >= 0 ? flags.coarse_levels : coarse_levels_for(options.match.disparities);
  const int last = options.match.least_disparity + options.match.disparities - 1;
  const double nearest_m =
      distance_from_disparity(pair.camera, pair.baseline_m, pair.camera.centre_px.x(), std::max(1, last));
  StereoSetup setup{left, right, StereoMatcher(file.calibration, left.name, right.name, options), nearest_m, {}};
  setup.said.push_back(rectification_text(pair));
  setup.said.push_back(
      fmt::format("searched: {} disparities from {}, which is from {:.3f} m on; one pixel is {:.1f} mm at 1 m",
                  options.match.disparities, options.match.least_disparity, nearest_m, 1e3 / disparity_at(pair, 1.0)));
  return setup;
}

StereoSummary summary_of(const StereoFrame& frame) {
  std::vector<double> depths, sigmas;
  for (int v = 0; v < frame.points.height; ++v) {
    for (int u = 0; u < frame.points.width; ++u) {
      const StereoPoint& point = frame.points.at(u, v);
      if (point.sigma_m == 0) continue;
      depths.push_back(point.z_m);
      sigmas.push_back(point.sigma_m);
    }
  }
  if (depths.empty()) return {};
  return {static_cast<int>(depths.size()), median(depths), median(sigmas)};
}

}  // namespace raybundle::apps
