// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "survey_text.hpp"

#include <fmt/format.h>

#include <cmath>

#include "pose_json.hpp"
#include "terminal.hpp"

namespace raybundle::apps {
namespace {

std::string range_text(double range_m) {
  if (std::isinf(range_m)) return "far";
  return range_m < 1000.0 ? fmt::format("{:.1f} m", range_m) : fmt::format("{:.3f} km", range_m / 1000.0);
}

nlohmann::ordered_json number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
}

std::string line_of(const SurveyImage& image) {
  const std::string place = std::isnan(image.pose_sigma[3])
                                ? std::string("rotation by directions alone")
                                : fmt::format("placed to {:.2f} m", image.pose_sigma.tail<3>().norm());
  const double factor = image.variance_factor;
  const std::string verdict =
      std::isnan(factor) ? "nothing is left over to judge it by"
      : factor < 2.0     ? fmt::format("as the sigmas say (chi² {:.2f} for each degree of freedom)", factor)
                         : fmt::format(
                               "more than the sigmas say (chi² {:.1f} for each degree of freedom): the lens model, the "
                                   "survey or the sightings are worse than stated",
                               factor);
  std::string left_out;
  for (const LandmarkResidual& landmark : image.landmarks) {
    if (!landmark.used) left_out += (left_out.empty() ? "; left out: " : ", ") + landmark.landmark;
  }
  return fmt::format("{}, camera {}: {:.2f} px rms, {}; {}{}\n", image.image, image.camera, image.rms_px, place,
                     verdict, left_out);
}

}  // namespace

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

nlohmann::ordered_json json_from_survey(const std::vector<SurveyImage>& images) {
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
                    {"camera", image.camera},
                    {"camera_from_local", json_from_pose(image.camera_from_local)},
                    {"pose_sigma", sigma},
                    {"rms_px", image.rms_px},
                    {"variance_factor", number(image.variance_factor)},
                    {"landmarks", landmarks}});
  }
  return list;
}

nlohmann::ordered_json json_from_survey(const SurveySummary& survey) {
  nlohmann::ordered_json parameters = nlohmann::ordered_json::array();
  for (const DraggedParameter& parameter : survey.parameters) {
    parameters.push_back({{"name", parameter.name},
                          {"without", parameter.without},
                          {"with", parameter.with},
                          {"sigma_without", parameter.sigma_without}});
  }
  return {{"rms_px", number(rms_px(survey.images))},
          {"drag_sigmas", drag_sigmas(survey.parameters)},
          {"parameters", parameters},
          {"images", json_from_survey(survey.images)}};
}

std::string survey_table(const std::vector<SurveyImage>& images) {
  std::vector<std::vector<std::string>> rows{
      {"image", "camera", "landmark", "range", "du px", "dv px", "sigma px", "sigmas", ""}};
  for (const SurveyImage& image : images) {
    for (const LandmarkResidual& l : image.landmarks) {
      rows.push_back({image.image, image.camera, l.landmark, range_text(l.range_m),
                      fmt::format("{:.2f}", l.residual_px.x()), fmt::format("{:.2f}", l.residual_px.y()),
                      fmt::format("{:.2f}", l.sigma_px), fmt::format("{:.1f}", l.sigmas), l.used ? "" : "left out"});
    }
  }
  return text_table(rows) + survey_lines(images);
}

std::string survey_lines(const std::vector<SurveyImage>& images) {
  std::string text;
  for (const SurveyImage& image : images) text += line_of(image);
  return text;
}

}  // namespace raybundle::apps
