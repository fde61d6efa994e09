// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "laser_verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/quantile.hpp"
#include "terminal.hpp"

namespace raybundle::apps {
namespace {

// Depths between which points are counted together [m].
constexpr std::pair<double, double> kDepthBands[] = {{0.0, 0.4}, {0.4, 0.75}, {0.75, 1.25}, {1.25, 1000.0}};

constexpr double kTolerances = 3.0;    // of the labels: the boards' places are uncertain too
constexpr double kAboutAsMany = 0.98;  // of the dots: some lie at the rim of the tolerance
constexpr double kDriftSigmas = 5.0;   // that a wavelength must be off to be worth a word

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

// The wavelength that the dots show, if the beams there explain them at least as well: a projector that has moved looks
// like another wavelength to the few dots that still lie near a beam.
void judge_wavelength(const Calibration& calibration, const CalibrationProblem& observed,
                      const std::vector<std::optional<Rigid3>>& rig_from_target, double tolerance_px,
                      LaserVerdict& verdict) {
  const auto wavelength = estimate_wavelength(calibration, observed, rig_from_target);
  if (!wavelength) return;
  Calibration retuned = calibration;
  retuned.laser = at_wavelength(*calibration.laser, wavelength->scale);
  const auto explained = static_cast<int>(explain_dots(retuned, observed, rig_from_target, tolerance_px).size());
  const bool about_as_many = explained >= kAboutAsMany * static_cast<double>(verdict.explained.size());
  if (!about_as_many || explained < verdict.min_share * verdict.expected) return;
  verdict.wavelength = wavelength;
  verdict.explained_retuned = explained;
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

bool LaserVerdict::drifted() const {
  return wavelength && std::abs(wavelength->change()) > kDriftSigmas * wavelength->sigma;
}

bool LaserVerdict::enough_dots() const {
  const int belong = std::max(static_cast<int>(explained.size()), retuned ? explained_retuned : 0);
  return belong > 0 && belong >= min_share * expected;
}

LaserVerdict judge_laser(const Calibration& calibration, const CalibrationProblem& observed,
                         const CalibrationResult& placed, const LaserGate& gate) {
  LaserVerdict verdict;
  verdict.limit_mm = gate.max_plane_mm;
  verdict.min_share = gate.min_share;
  const std::vector<std::optional<Rigid3>> rig_from_target = placed_boards(calibration, observed, placed);
  for (std::size_t v = 0; v < observed.views.size(); ++v) {
    verdict.boards += rig_from_target[v].has_value();
    if (rig_from_target[v]) verdict.dots += static_cast<int>(observed.views[v].dots.size());
  }
  for (const DotsOnBoard& of_view : dots_on_boards(calibration, observed, rig_from_target)) {
    verdict.expected += of_view.to_explain();
  }
  const double label_px = calibration.laser->advice ? calibration.laser->advice->ambiguity.tolerance_px : 1.0;
  const double tolerance_px = kTolerances * label_px;
  verdict.explained = explain_dots(calibration, observed, rig_from_target, tolerance_px);
  double squares = 0.0;
  std::vector<double> distances;
  for (const HeldOutDot& dot : verdict.explained) {
    squares += dot.residual_px.squaredNorm();
    distances.push_back(dot.residual_px.norm());
  }
  if (!distances.empty()) verdict.median_px = median(distances);
  verdict.rms_px = std::sqrt(squares / std::max<double>(1.0, static_cast<double>(verdict.explained.size())));
  if (calibration.laser->grating) judge_wavelength(calibration, observed, rig_from_target, tolerance_px, verdict);
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
  if (verdict.drifted()) {
    fmt::print(
        "  the laser's wavelength is {:.5f} ± {:.5f} times that of the calibration: it is warmer or cooler than then; "
        "--retune FILE writes the calibration that fits\n",
        1.0 + verdict.wavelength->change(), verdict.wavelength->sigma);
  }
}

std::string why_failed(const LaserVerdict& verdict) {
  if (verdict.boards == 0) return "laser: no board could be placed, so that its dots cannot be judged";
  if (verdict.dots == 0) {
    return "laser: no dot was found on a board; are the images with the laser on and off the same, or swapped?";
  }
  if (verdict.enough_dots()) {
    return fmt::format("laser: its points lie {:.2f} mm rms off the boards, above the limit of {:.2f} mm (--max-plane)",
                       verdict.plane_mm(), verdict.limit_mm);
  }
  if (verdict.expected == 0) {
    return "laser: none of its beams meets a board in these images; has the projector moved against the cameras since, "
           "or is it another one? Calibrate again";
  }
  return fmt::format(
      "laser: only {} of the {} dots that its beams should explain belong to one, and {:.0f} % have to (--min-dots); "
      "{}",
      verdict.explained.size(), verdict.expected, 100 * verdict.min_share,
      verdict.drifted() ? "at the wavelength that they show they do: --retune FILE writes the calibration that fits"
                        : "has the projector moved against the cameras since, or is it another one? Calibrate again, "
                          "with these images among the others");
}

nlohmann::ordered_json json_of(const LaserVerdict& verdict) {
  nlohmann::ordered_json bands = nlohmann::ordered_json::array();
  for (const auto& [nearest, farthest] : kDepthBands) {
    bands.push_back(
        {{"nearest_m", nearest}, {"farthest_m", farthest}, {"plane_rms_mm", verdict.plane_mm(nearest, farthest)}});
  }
  nlohmann::ordered_json json{{"dots", verdict.dots},
                              {"expected", verdict.expected},
                              {"explained", verdict.explained.size()},
                              {"rms_px", verdict.rms_px},
                              {"median_px", verdict.median_px},
                              {"plane_rms_mm", verdict.plane_mm()},
                              {"min_dots_share", verdict.min_share},
                              {"bands", bands},
                              {"passed", verdict.passed()}};
  if (verdict.wavelength) {
    json["wavelength"] = {{"scale", verdict.wavelength->scale},
                          {"sigma", verdict.wavelength->sigma},
                          {"dots", verdict.wavelength->dots},
                          {"drifted", verdict.drifted()}};
  }
  return json;
}

void write_retuned(const std::string& path, const CalibrationFile& file, const std::optional<LaserVerdict>& verdict) {
  if (!verdict || !verdict->wavelength) {
    throw Error(
        ErrorKind::kNotEnoughData,
        "there is no wavelength at which the beams would explain these dots; --retune needs a calibration whose "
        "beams follow a grating, a projector that has not moved since, and at least ten dots on boards");
  }
  CalibrationFile retuned = file;
  retuned.calibration.laser = at_wavelength(*file.calibration.laser, verdict->wavelength->scale);
  write_calibration(path, retuned);
  say("wrote " + path);
}

}  // namespace raybundle::apps
