// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/App.hpp>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "chosen_camera.hpp"
#include "number_flags.hpp"
#include "page_text.hpp"
#include "raybundle/calibrate/survey.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "survey_input.hpp"
#include "survey_text.hpp"
#include "terminal.hpp"
#include "verbs.hpp"

namespace raybundle::apps {
namespace {

struct SurveyFlags {
  std::string calibration, camera;
  SurveyInput input;
  double max_rms_px = 0.0;  // 0: no gate
  bool json = false;
};

// The camera of --camera or the only one; else those that the sightings name, each of which then has to name one.
std::set<std::string> cameras_meant(const Calibration& calibration, const std::string& name, const Survey& survey) {
  if (!name.empty() || calibration.cameras.size() == 1) return {chosen_camera(calibration, name).name};
  std::set<std::string> names;
  for (const Sighting& sighting : survey.sightings) names.insert(chosen_camera(calibration, sighting.camera).name);
  return names;
}

void run(const SurveyFlags& flags) {
  const CalibrationFile file = read_calibration(flags.calibration);
  const Survey survey = read_survey(flags.input);
  PlacedImages placed;
  for (const std::string& name : cameras_meant(file.calibration, flags.camera, survey)) {
    PlacedImages of_camera = check_survey(file.calibration, camera_named(file.calibration, name), survey);
    std::ranges::move(of_camera.images, std::back_inserter(placed.images));
    std::ranges::move(of_camera.not_placed, std::back_inserter(placed.not_placed));
  }
  if (placed.images.empty()) throw Error(ErrorKind::kNotEnoughData, placed.not_placed.front());
  const std::vector<SurveyImage>& images = placed.images;
  const double rms = rms_px(images);
  const bool passed = flags.max_rms_px <= 0.0 || (rms <= flags.max_rms_px && placed.not_placed.empty());
  for (const std::string& reason : placed.not_placed) say_warning(reason + "; it is left out");
  if (flags.json) {
    const nlohmann::ordered_json json{{"passed", passed},
                                      {"rms_px", std::isfinite(rms) ? nlohmann::ordered_json(rms) : nullptr},
                                      {"sighting_sigma_px", flags.input.sigma_px},
                                      {"not_placed", placed.not_placed},
                                      {"images", json_from_survey(images)}};
    fmt::print("{}\n", text_of_json(json, 2));
  } else {
    fmt::print("{}", survey_table(images));
    if (!passed && rms > flags.max_rms_px) {
      fmt::print("FAIL  {:.2f} px rms over the landmarks in use is above {:.2f} px (--max-rms)\n", rms,
                 flags.max_rms_px);
    } else if (!passed) {
      fmt::print("FAIL  of {} images {} could not be placed (--max-rms)\n", images.size() + placed.not_placed.size(),
                 placed.not_placed.size());
    }
  }
  if (!passed) throw GateFailed{};
}

}  // namespace

void add_survey_verb(CLI::App& app) {
  auto flags = std::make_shared<SurveyFlags>();
  CLI::App* verb = app.add_subcommand("survey", "a calibration against surveyed landmarks: the far field");
  verb->add_option("calibration", flags->calibration, "calibration.json")->required()->type_name("CALIBRATION");
  add_survey_flags(*verb, true, flags->input);
  verb->add_option("--camera", flags->camera,
                   "name; may be left out when there is only one, or when the sightings name theirs")
      ->type_name("NAME");
  verb->add_option("--max-rms", flags->max_rms_px,
                   "gate: rms over the landmarks in use, of which a quarter may be left out [px], and "
                   "every image is placed")
      ->check(above_zero);
  verb->add_flag("--json", flags->json, "print the result as JSON");
  verb->footer(
      "Example:\n  raybundle survey out/calibration.json --landmarks towers.csv --sightings clicks.csv \\\n"
      "      --origin 43.5642,1.4811,196 --height ellipsoidal\n"
      "Exit code 1 when the gate fails.");
  verb->callback([flags] { run(*flags); });
}

}  // namespace raybundle::apps
