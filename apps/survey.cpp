// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/App.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "chosen_camera.hpp"
#include "pose_json.hpp"
#include "raybundle/calibrate/survey.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "raybundle/io/survey_files.hpp"
#include "raybundle/scene/csv.hpp"
#include "terminal.hpp"
#include "verbs.hpp"

namespace raybundle::apps {
namespace {

struct SurveyFlags {
  std::string calibration, landmarks, sightings, camera, height;
  std::vector<double> origin;  // latitude, longitude, height above the ellipsoid
  double sigma_px = 0.5;
  double max_rms_px = 0.0;  // 0: no gate
  bool json = false;
};

double rms_px(const std::vector<SurveyImage>& images) {
  double squares = 0.0;
  int used = 0;
  for (const SurveyImage& image : images) {
    for (const LandmarkResidual& landmark : image.landmarks) {
      if (!landmark.used) continue;
      squares += landmark.residual_px.squaredNorm();
      ++used;
    }
  }
  return used > 0 ? std::sqrt(squares / used) : std::nan("");
}

nlohmann::ordered_json json_of(const std::vector<SurveyImage>& images, const SurveyFlags& flags, bool passed) {
  const auto number = [](double value) {
    return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
  };
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const SurveyImage& image : images) {
    nlohmann::ordered_json landmarks = nlohmann::ordered_json::array();
    for (const LandmarkResidual& landmark : image.landmarks) {
      landmarks.push_back({{"name", landmark.landmark},
                           {"pixel", {landmark.pixel.x(), landmark.pixel.y()}},
                           {"residual_px", {number(landmark.residual_px.x()), number(landmark.residual_px.y())}},
                           {"range_m", number(landmark.range_m)},
                           {"sigma_px", number(landmark.sigma_px)},
                           {"sigmas", number(landmark.sigmas)},
                           {"used", landmark.used}});
    }
    nlohmann::ordered_json sigma = nlohmann::ordered_json::array();
    for (const double value : image.pose_sigma) sigma.push_back(number(value));
    list.push_back({{"image", image.image},
                    {"camera_from_local", json_from_pose(image.camera_from_local)},
                    {"pose_sigma", sigma},
                    {"rms_px", image.rms_px},
                    {"variance_factor", number(image.variance_factor)},
                    {"landmarks", landmarks}});
  }
  return {
      {"passed", passed}, {"rms_px", number(rms_px(images))}, {"sighting_sigma_px", flags.sigma_px}, {"images", list}};
}

std::string range_text(double range_m) {
  if (std::isinf(range_m)) return "far";
  return range_m < 1000.0 ? fmt::format("{:.1f} m", range_m) : fmt::format("{:.3f} km", range_m / 1000.0);
}

void print(const std::vector<SurveyImage>& images) {
  std::vector<std::vector<std::string>> rows{
      {"image", "landmark", "range", "du px", "dv px", "sigma px", "sigmas", ""}};
  for (const SurveyImage& image : images) {
    for (const LandmarkResidual& l : image.landmarks) {
      rows.push_back({image.image, l.landmark, range_text(l.range_m), fmt::format("{:.2f}", l.residual_px.x()),
                      fmt::format("{:.2f}", l.residual_px.y()), fmt::format("{:.2f}", l.sigma_px),
                      fmt::format("{:.1f}", l.sigmas), l.used ? "" : "left out"});
    }
  }
  fmt::print("{}", text_table(rows));
  for (const SurveyImage& image : images) {
    const std::string place = std::isnan(image.pose_sigma[3])
                                  ? std::string("rotation by directions alone")
                                  : fmt::format("placed to {:.2f} m", image.pose_sigma.tail<3>().norm());
    const double factor = image.variance_factor;
    const std::string verdict = std::isnan(factor) ? "nothing is left over to judge it by"
                                : factor < 2.0
                                    ? fmt::format("as the sigmas say (chi² {:.2f} for each degree of freedom)", factor)
                                    : fmt::format(
                                          "more than the sigmas say (chi² {:.1f} for each degree of freedom): the "
                                          "lens model, the survey or the sightings are worse than stated",
                                          factor);
    fmt::print("{}: {:.2f} px rms, {}; {}\n", image.image, image.rms_px, place, verdict);
  }
}

void run(const SurveyFlags& flags) {
  const CalibrationFile file = read_calibration(flags.calibration);
  const RigCamera& camera = chosen_camera(file.calibration, flags.camera);
  std::optional<Geodetic> origin;
  if (!flags.origin.empty()) origin = Geodetic{flags.origin[0], flags.origin[1], flags.origin[2]};
  std::optional<HeightDatum> datum;
  if (!flags.height.empty()) datum = height_datum_from_word(flags.height);
  const std::vector<Landmark> landmarks =
      landmarks_from_csv_text(text_of_file(flags.landmarks), flags.landmarks, origin, datum);
  const std::vector<Sighting> sightings =
      sightings_from_csv_text(text_of_file(flags.sightings), flags.sightings, landmarks);
  const std::vector<SurveyImage> images = check_survey(file.calibration, camera, landmarks, sightings, flags.sigma_px);
  const bool passed = flags.max_rms_px <= 0.0 || rms_px(images) <= flags.max_rms_px;
  if (flags.json) {
    fmt::print("{}\n", json_of(images, flags, passed).dump(2));
  } else {
    print(images);
    if (!passed) {
      fmt::print("FAIL  {:.2f} px rms over all landmarks is above {:.2f} px (--max-rms)\n", rms_px(images),
                 flags.max_rms_px);
    }
  }
  if (!passed) throw GateFailed{};
}

}  // namespace

void add_survey_verb(CLI::App& app) {
  auto flags = std::make_shared<SurveyFlags>();
  CLI::App* verb = app.add_subcommand("survey", "a calibration against surveyed landmarks: the far field");
  verb->add_option("calibration", flags->calibration, "calibration.json")->required()->type_name("CALIBRATION");
  verb->add_option("--landmarks", flags->landmarks,
                   "CSV whose header is name,lat,lon,height,sigma or name,east,north,up,sigma or "
                   "name,azimuth,elevation,sigma (degrees, metres)")
      ->required()
      ->type_name("FILE");
  verb->add_option("--sightings", flags->sightings, "CSV: image,u,v,name")->required()->type_name("FILE");
  verb->add_option("--camera", flags->camera, "name; may be left out when there is only one")->type_name("NAME");
  verb->add_option("--origin", flags->origin,
                   "of the local frame: latitude, longitude [deg], height above the ellipsoid [m]")
      ->delimiter(',')
      ->expected(3)
      ->type_name("LAT,LON,HEIGHT");
  verb->add_option("--height", flags->height,
                   "what heights are above: ellipsoidal, or orthometric:N with the geoid's height N there [m]")
      ->type_name("DATUM");
  verb->add_option("--sigma", flags->sigma_px, "of a sighting's u and v [px]")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  verb->add_option("--max-rms", flags->max_rms_px, "gate: rms over all landmarks [px]")->check(CLI::PositiveNumber);
  verb->add_flag("--json", flags->json, "print the result as JSON");
  verb->footer(
      "Example:\n  raybundle survey out/calibration.json --landmarks towers.csv --sightings clicks.csv \\\n"
      "      --origin 43.5642,1.4811,196 --height ellipsoidal\n"
      "Exit code 1 when the gate fails.");
  verb->callback([flags] { run(*flags); });
}

}  // namespace raybundle::apps
