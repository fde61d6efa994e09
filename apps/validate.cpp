// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "held_out.hpp"
#include "input_flags.hpp"
#include "laser_verdict.hpp"
#include "number_flags.hpp"
#include "output_folder.hpp"
#include "page_text.hpp"
#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "residual_text.hpp"
#include "terminal.hpp"
#include "verbs.hpp"

namespace raybundle::apps {
namespace {

struct ValidateFlags {
  std::string calibration;
  InputFlags input;
  double max_rms_px = 0.0;  // 0: twice what the calibration itself reached
  double min_share = 0.75;  // of the views, which have to fit at all
  LaserGate laser;
  std::string retuned;  // file for the calibration with the wavelength that the dots show; empty: none
  bool json = false;
  bool laser_gate = false;  // whether anything was asked of the laser
};

struct CameraVerdict {
  std::string name;
  CameraSummary summary;
  double limit_px = 0.0;
  double min_share = 0.0;
  ResidualBias bias = {};
  std::optional<double> own_rms_px = {};  // of a lens that is fitted to these images; nothing where they are too few
  int views_apart = 0;                    // of those used, in which another camera saw the board in another place

  int views_fitting() const { return summary.views_used - views_apart; }
  double share() const { return summary.views_total > 0 ? double(views_fitting()) / summary.views_total : 0.0; }
  bool fits() const { return summary.views_used > 0 && summary.rms_px <= limit_px; }
  bool enough_views() const { return views_fitting() > 0 && share() >= min_share; }
  bool passed() const { return fits() && enough_views(); }
  double times_own() const { return own_rms_px && *own_rms_px > 0 ? summary.rms_px / *own_rms_px : 1.0; }
};

double limit_px(const ValidateFlags& flags, const CalibrationFile& file, const std::string& camera) {
  if (flags.max_rms_px > 0) return flags.max_rms_px;
  const std::vector<RigCamera>& cameras = file.calibration.cameras;
  const auto known = std::ranges::find(cameras, camera, &RigCamera::name);  // there: held_out() asked for it
  return 2.0 * file.summaries[static_cast<std::size_t>(known - cameras.begin())].rms_px;
}

void print_json(const std::vector<CameraVerdict>& verdicts, const std::optional<LaserVerdict>& dots, bool passed) {
  nlohmann::ordered_json cameras = nlohmann::ordered_json::array();
  for (const CameraVerdict& verdict : verdicts) {
    cameras.push_back({{"name", verdict.name},
                       {"rms_px", verdict.summary.rms_px},
                       {"median_px", verdict.summary.median_px},
                       {"limit_px", verdict.limit_px},
                       {"views_used", verdict.summary.views_used},
                       {"views_apart", verdict.views_apart},
                       {"views_total", verdict.summary.views_total},
                       {"min_views_share", verdict.min_share},
                       {"corners_used", verdict.summary.corners_used},
                       {"residuals", json_from_bias(verdict.bias)},
                       {"own_rms_px", verdict.own_rms_px ? nlohmann::ordered_json(*verdict.own_rms_px) : nullptr},
                       {"passed", verdict.passed()}});
  }
  nlohmann::ordered_json json{{"passed", passed}, {"cameras", cameras}};
  if (dots) json["laser"] = json_of(*dots);
  fmt::print("{}\n", text_of_json(json, 2));
}

void print_table(const std::vector<CameraVerdict>& verdicts) {
  std::vector<std::vector<std::string>> rows{{"camera", "views", "corners", "rms px", "median px", "limit px", ""}};
  for (const CameraVerdict& verdict : verdicts) {
    const CameraSummary& s = verdict.summary;
    rows.push_back({verdict.name, fmt::format("{}/{}", verdict.views_fitting(), s.views_total),
                    fmt::format("{}", s.corners_used), fmt::format("{:.3f}", s.rms_px),
                    fmt::format("{:.3f}", s.median_px), fmt::format("{:.3f}", verdict.limit_px),
                    verdict.passed() ? "pass" : "FAIL"});
  }
  fmt::print("{}", text_table(rows));
  for (const CameraVerdict& verdict : verdicts) {
    if (verdict.summary.views_used > 0) fmt::print("{}", bias_text(verdict.name, verdict.bias));
  }
}

// What a lens that is fitted to these images leaves of them. A camera that has changed, or another one, may pass a gate that
// was made for worse images.
void fit_own_lenses(const CalibrationProblem& held, const CalibrateOptions& options,
                    std::vector<CameraVerdict>& verdicts) {
  constexpr int kFewestViews = 8;
  CalibrationProblem free = held;
  free.rules.clear();
  try {
    const CalibrationResult own = calibrate(free, options);
    for (std::size_t c = 0; c < verdicts.size(); ++c) {
      const bool enough = std::min(own.cameras[c].views_used, verdicts[c].summary.views_used) >= kFewestViews;
      if (enough) verdicts[c].own_rms_px = own.cameras[c].rms_px;
    }
  } catch (const Error&) {
    return;  // they do not tell a lens
  }
}

void warn_of_other_lenses(const std::vector<CameraVerdict>& verdicts) {
  constexpr double kMuch = 1.5;
  for (const CameraVerdict& verdict : verdicts) {
    if (!verdict.passed() || verdict.times_own() < kMuch) continue;
    say_warning(
        fmt::format("camera {} passes its gate, but a lens that is fitted to these images fits them {:.1f} times "
                    "better, to {:.3f} px: the camera has changed since it was calibrated, or is another one",
                    verdict.name, verdict.times_own(), *verdict.own_rms_px));
  }
}

// Why a camera failed.
std::string why_failed(const CameraVerdict& verdict) {
  const CameraSummary& s = verdict.summary;
  if (s.views_used == 0) return fmt::format("{}: none of its {} views fits", verdict.name, s.views_total);
  if (!verdict.enough_views()) {
    const std::string apart =
        fmt::format("; in {} of the others another camera saw the board in another place", verdict.views_apart);
    return fmt::format("{}: only {} of its {} views fit, and {:.0f} % have to (--min-views){}", verdict.name,
                       verdict.views_fitting(), s.views_total, 100 * verdict.min_share,
                       verdict.views_apart > 0 ? apart : "");
  }
  return fmt::format("{}: {:.3f} px is above its limit of {:.3f} px (--max-rms)", verdict.name, s.rms_px,
                     verdict.limit_px);
}

void print_next_step(const std::vector<CameraVerdict>& verdicts) {
  for (const CameraVerdict& verdict : verdicts) {
    if (!verdict.passed()) fmt::print("FAIL  {}\n", why_failed(verdict));
  }
  const auto apart = [](const CameraVerdict& verdict) { return !verdict.enough_views() && verdict.views_apart > 0; };
  if (std::ranges::any_of(verdicts, apart)) {
    fmt::print(
        "next  do the images that have the same number belong to the same moment? If so the cameras have moved against "
        "each other since, or the board moved between their exposures: calibrate again, with the board held still\n");
    return;
  }
  fmt::print(
      "next  look at a few of these images: sharp, the same board, the same focus and zoom? If so the camera has "
      "changed since: calibrate again, with these images among the others\n");
}

void run(const ValidateFlags& flags) {
  const CalibrationFile file = read_calibration(flags.calibration);
  if (flags.max_rms_px == 0 && file.summaries.empty()) {
    throw Error(ErrorKind::kBadInput, "the calibration does not say its own rms; give --max-rms");
  }
  if (!flags.retuned.empty()) require_writable_file(flags.retuned, "--retune");
  const Dataset dataset = dataset_of(flags.input, false);
  const DetectedImages images = observe(flags.input, dataset);
  require_views(images);
  for (const std::string& hint : images.hints) say_warning(hint);
  const HeldOut held = held_out(file, images.observations.problem);
  const CalibrationProblem& problem = held.problem;
  for (const std::string& warning : held.warnings) say_warning(warning);
  CalibrateOptions options;
  options.threads = dataset.options.threads;
  options.estimate_shape = false;
  options.tie_sigma = 5.0;  // more than while calibrating: the error of the calibration adds to that of the frame
  const CalibrationResult result = calibrate(problem, options);

  std::vector<CameraVerdict> verdicts;
  for (std::size_t c = 0; c < problem.cameras.size(); ++c) {
    const std::string& name = problem.cameras[c].name;
    const Camera& lens = camera_named(file.calibration, name).camera;
    verdicts.push_back({name, result.cameras[c], limit_px(flags, file, name), flags.min_share,
                        residual_bias(problem, result, static_cast<int>(c), lens)});
  }
  for (const SetAside& aside : result.set_aside) {
    const auto camera = static_cast<std::size_t>(problem.views[aside.view].camera);
    verdicts[camera].views_apart += aside.scope == SetAside::Scope::kExtrinsics;
  }
  fit_own_lenses(problem, options, verdicts);
  warn_of_other_lenses(verdicts);
  std::optional<LaserVerdict> dots;
  if (file.calibration.laser && images.observations.problem.laser) {
    dots = judge_laser(file.calibration, images.observations.problem, result, flags.laser);
  } else if (images.observations.problem.laser) {
    say_warning("the calibration has no laser beams, so the dots are not judged");
  }
  const bool cameras_passed = std::ranges::all_of(verdicts, &CameraVerdict::passed);
  if (!flags.retuned.empty() && !cameras_passed) {
    say_warning(flags.retuned +
                " is not written: dots are judged on the boards that the cameras place, and a camera "
                "misses its gate");
  } else if (!flags.retuned.empty()) {
    write_retuned(flags.retuned, file, dots);
    dots->retuned = true;
  }
  const bool gate_without_laser = !dots && flags.laser_gate;
  const bool passed = cameras_passed && (dots ? dots->passed() : !gate_without_laser);
  if (flags.json) {
    print_json(verdicts, dots, passed);
  } else {
    print_table(verdicts);
    if (dots) print_laser(*dots);
    for (const SetAside& aside : result.set_aside) {
      say(fmt::format("set aside: {}: {}", view_name(problem, problem.views[aside.view]), aside.reason));
    }
    if (gate_without_laser) {
      fmt::print("FAIL  laser: nothing to judge, no beams in the calibration or no laser in these data\n");
    }
    if (dots && !dots->passed()) fmt::print("FAIL  {}\n", why_failed(*dots));
    if (!cameras_passed) print_next_step(verdicts);
  }
  if (!passed) throw GateFailed{};
}

}  // namespace

void add_validate_verb(CLI::App& app) {
  auto flags = std::make_shared<ValidateFlags>();
  CLI::App* verb = app.add_subcommand("validate", "a calibration against other images: held-out residuals, exit code");
  verb->add_option("calibration", flags->calibration, "calibration.json")->required()->type_name("CALIBRATION");
  add_input_flags(*verb, flags->input);
  verb->add_option("--max-rms", flags->max_rms_px,
                   "gate for each camera [px]; default: twice the calibration's own rms")
      ->check(above_zero);
  verb->add_option("--min-views", flags->min_share, "gate for each camera: share of its views that have to fit")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  verb->add_option("--max-plane", flags->laser.max_plane_mm,
                   "gate for the laser: rms distance of its points from the boards [mm]")
      ->check(above_zero);
  verb->add_option("--min-dots", flags->laser.min_share,
                   "gate for the laser: share of its dots on boards that have to belong to a beam")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  verb->add_option("--retune", flags->retuned,
                   "write the calibration with the laser's wavelength as these images show it: temperature moves it")
      ->type_name("FILE");
  verb->add_flag("--json", flags->json, "print the result as JSON");
  verb->footer(
      "Example:\n  raybundle validate out/calibration.json --target chessboard:9x6:25mm --camera "
      "left='later/left*.jpg'\n"
      "Exit code 1 when a camera or the laser misses its gate.");
  verb->callback([flags, verb] {
    flags->laser_gate = verb->count("--max-plane") + verb->count("--min-dots") > 0;
    run(*flags);
  });
}

}  // namespace raybundle::apps
