// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "laser_verdict.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/quantile.hpp"

namespace raybundle::apps {
namespace {

// Depths between which points are counted together [m].
constexpr std::pair<double, double> kDepthBands[] = {{0.0, 0.4}, {0.4, 0.75}, {0.75, 1.25}, {1.25, 1000.0}};

constexpr double kTolerances = 3.0;   // of the labels: the boards' places are uncertain too
constexpr double kDriftSigmas = 5.0;  // that a wavelength must be off to be worth a word

/// Where the boards of the views lie; the held-out rig is seen from its first camera.
std::vector<std::optional<Rigid3>> placed_boards(const Calibration& calibration, const CalibrationProblem& observed,
                                                 const CalibrationResult& placed) {
  const Rigid3 rig_from_first = camera_named(calibration, observed.cameras.front().name).camera_from_rig.inverse();
  std::vector<std::optional<Rigid3>> rig_from_target;
  for (const ViewResult& view : placed.views) {
    rig_from_target.push_back(view.pose < 0 ? std::nullopt
                                            : std::optional(rig_from_first * placed.poses[view.pose].rig_from_target));
  }
  return rig_from_target;
}

bool drifted(const LaserVerdict& verdict) {
  return verdict.wavelength && std::abs(verdict.wavelength->change()) > kDriftSigmas * verdict.wavelength->sigma;
}

}  // namespace

double LaserVerdict::plane_mm(double nearest_m, double farthest_m) const {
  double sum = 0.0;
  int count = 0;
  for (const HeldOutDot& dot : explained) {
    if (dot.depth_m < nearest_m || dot.depth_m >= farthest_m) continue;
    sum += dot.off_board_m * dot.off_board_m;
    ++count;
  }
  return count > 0 ? 1e3 * std::sqrt(sum / count) : std::nan("");
}

LaserVerdict judge_laser(const Calibration& calibration, const CalibrationProblem& observed,
                         const CalibrationResult& placed) {
  LaserVerdict verdict;
  const std::vector<std::optional<Rigid3>> rig_from_target = placed_boards(calibration, observed, placed);
  for (std::size_t v = 0; v < observed.views.size(); ++v) {
    if (rig_from_target[v]) verdict.dots += static_cast<int>(observed.views[v].dots.size());
  }
  const double tolerance_px = calibration.laser->advice ? calibration.laser->advice->ambiguity.tolerance_px : 1.0;
  verdict.explained = explain_dots(calibration, observed, rig_from_target, kTolerances * tolerance_px);
  double squares = 0.0;
  std::vector<double> distances;
  for (const HeldOutDot& dot : verdict.explained) {
    squares += dot.residual_px.squaredNorm();
    distances.push_back(dot.residual_px.norm());
  }
  if (!distances.empty()) verdict.median_px = median(distances);
  verdict.rms_px = std::sqrt(squares / std::max<double>(1.0, static_cast<double>(verdict.explained.size())));
  if (calibration.laser->grating) verdict.wavelength = estimate_wavelength(calibration, observed, rig_from_target);
  return verdict;
}

void print_laser(const LaserVerdict& verdict) {
  fmt::print(
      "laser: {} of {} dots belong to a beam, {:.3f} px rms and {:.3f} px in the median from where it meets the "
      "board{}\n",
      verdict.explained.size(), verdict.dots, verdict.rms_px, verdict.median_px, verdict.passed() ? "" : "  FAIL");
  for (const auto& [nearest, farthest] : kDepthBands) {
    const double mm = verdict.plane_mm(nearest, farthest);
    if (!std::isfinite(mm)) continue;
    const std::string band = farthest < 1000.0 ? fmt::format("{:.2f} m to {:.2f} m", nearest, farthest)
                                               : fmt::format("beyond {:.2f} m", nearest);
    fmt::print("  {}: points lie {:.2f} mm rms off the board\n", band, mm);
  }
  if (drifted(verdict)) {
    fmt::print(
        "  the laser's wavelength is {:.5f} ± {:.5f} times that of the calibration: it is warmer or cooler than then; "
        "--retune FILE writes the calibration that fits\n",
        1.0 + verdict.wavelength->change(), verdict.wavelength->sigma);
  }
}

nlohmann::ordered_json json_of(const LaserVerdict& verdict) {
  nlohmann::ordered_json bands = nlohmann::ordered_json::array();
  for (const auto& [nearest, farthest] : kDepthBands) {
    bands.push_back(
        {{"nearest_m", nearest}, {"farthest_m", farthest}, {"plane_rms_mm", verdict.plane_mm(nearest, farthest)}});
  }
  nlohmann::ordered_json json{
      {"dots", verdict.dots},           {"explained", verdict.explained.size()}, {"rms_px", verdict.rms_px},
      {"median_px", verdict.median_px}, {"plane_rms_mm", verdict.plane_mm()},    {"bands", bands},
      {"passed", verdict.passed()}};
  if (verdict.wavelength) {
    json["wavelength"] = {{"scale", verdict.wavelength->scale},
                          {"sigma", verdict.wavelength->sigma},
                          {"dots", verdict.wavelength->dots},
                          {"drifted", drifted(verdict)}};
  }
  return json;
}

void write_retuned(const std::string& path, const CalibrationFile& file, const std::optional<LaserVerdict>& verdict) {
  if (!verdict || !verdict->wavelength) {
    throw Error(ErrorKind::kNotEnoughData,
                "--retune needs a calibration whose beams follow a grating, and at least ten dots on boards near where "
                "its beams would be; these images do not show them");
  }
  CalibrationFile retuned = file;
  retuned.calibration.laser = at_wavelength(*file.calibration.laser, verdict->wavelength->scale);
  write_calibration(path, retuned);
}

}  // namespace raybundle::apps
