// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "input_flags.hpp"
#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "terminal.hpp"
#include "verbs.hpp"

namespace raybundle::apps {
namespace {

struct ValidateFlags {
  std::string calibration;
  InputFlags input;
  double max_rms_px = 0.0;  // 0: twice what the calibration itself reached
  bool json = false;
};

// The other observations with everything fixed to the calibration but the poses of the boards.
CalibrationProblem held_out_problem(const CalibrationFile& file, const CalibrationProblem& observed) {
  CalibrationProblem problem = observed;
  for (ProblemCamera& camera : problem.cameras) {
    const RigCamera& known = camera_named(file.calibration, camera.name);
    if (camera.size != known.camera.size) {
      throw Error(ErrorKind::kBadInput,
                  fmt::format("camera {} has {}x{} images, but was calibrated at {}x{}", camera.name, camera.size.width,
                              camera.size.height, known.camera.size.width, known.camera.size.height));
    }
    camera.model = known.camera.model;
    camera.parameters = known.camera.parameters;
    camera.camera_from_rig = known.camera_from_rig;
  }
  problem.rules = {{"*.intrinsics", ParameterRule::Kind::kFixed, {}, 0.0}};
  if (problem.cameras.size() > 1) problem.rules.push_back({"*.camera_from_rig", ParameterRule::Kind::kFixed, {}, 0.0});
  return problem;
}

// The rig frame of the observations is that of their first camera.
void refer_to_first_camera(CalibrationProblem& problem) {
  const Rigid3 rig_from_first = problem.cameras.front().camera_from_rig->inverse();
  for (ProblemCamera& camera : problem.cameras) camera.camera_from_rig = *camera.camera_from_rig * rig_from_first;
}

struct CameraVerdict {
  std::string name;
  CameraSummary summary;
  double limit_px = 0.0;
  bool passed = false;
};

double limit_px(const ValidateFlags& flags, const CalibrationFile& file, const std::string& camera) {
  if (flags.max_rms_px > 0) return flags.max_rms_px;
  for (std::size_t c = 0; c < file.summaries.size(); ++c) {
    if (file.calibration.cameras[c].name == camera) return 2.0 * file.summaries[c].rms_px;
  }
  throw Error(ErrorKind::kBadInput, "the calibration does not say its own rms; give --max-rms");
}

void print_json(const std::vector<CameraVerdict>& verdicts, bool passed) {
  nlohmann::ordered_json cameras = nlohmann::ordered_json::array();
  for (const CameraVerdict& verdict : verdicts) {
    cameras.push_back({{"name", verdict.name},
                       {"rms_px", verdict.summary.rms_px},
                       {"median_px", verdict.summary.median_px},
                       {"limit_px", verdict.limit_px},
                       {"views_used", verdict.summary.views_used},
                       {"views_total", verdict.summary.views_total},
                       {"corners_used", verdict.summary.corners_used},
                       {"passed", verdict.passed}});
  }
  fmt::print("{}\n", nlohmann::ordered_json{{"passed", passed}, {"cameras", cameras}}.dump(2));
}

void print_table(const std::vector<CameraVerdict>& verdicts) {
  std::vector<std::vector<std::string>> rows{{"camera", "views", "corners", "rms px", "median px", "limit px", ""}};
  for (const CameraVerdict& verdict : verdicts) {
    const CameraSummary& s = verdict.summary;
    rows.push_back({verdict.name, fmt::format("{}/{}", s.views_used, s.views_total), fmt::format("{}", s.corners_used),
                    fmt::format("{:.3f}", s.rms_px), fmt::format("{:.3f}", s.median_px),
                    fmt::format("{:.3f}", verdict.limit_px), verdict.passed ? "pass" : "FAIL"});
  }
  fmt::print("{}", text_table(rows));
}

void run(const ValidateFlags& flags) {
  const CalibrationFile file = read_calibration(flags.calibration);
  const DetectedImages images = observe(flags.input, dataset_of(flags.input, false));
  require_views(images);
  CalibrationProblem problem = held_out_problem(file, images.observations.problem);
  refer_to_first_camera(problem);
  CalibrateOptions options;
  options.threads = flags.input.detect.threads;
  options.estimate_shape = false;
  const CalibrationResult result = calibrate(problem, options);

  bool passed = true;
  std::vector<CameraVerdict> verdicts;
  for (std::size_t c = 0; c < problem.cameras.size(); ++c) {
    CameraVerdict verdict{problem.cameras[c].name, result.cameras[c], limit_px(flags, file, problem.cameras[c].name)};
    verdict.passed = verdict.summary.views_used > 0 && verdict.summary.rms_px <= verdict.limit_px;
    passed = passed && verdict.passed;
    verdicts.push_back(verdict);
  }
  if (flags.json) {
    print_json(verdicts, passed);
  } else {
    print_table(verdicts);
    for (const SetAside& aside : result.set_aside) {
      say(fmt::format("set aside: {}: {}", view_name(problem, problem.views[aside.view]), aside.reason));
    }
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
      ->check(CLI::PositiveNumber);
  verb->add_flag("--json", flags->json, "print the result as JSON");
  verb->footer(
      "Example:\n  raybundle validate out/calibration.json --target chessboard:9x6:25mm --camera "
      "left='later/left*.jpg'\n"
      "Exit code 1 when a camera misses its gate.");
  verb->callback([flags] { run(*flags); });
}

}  // namespace raybundle::apps
