// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "residual_text.hpp"

#include <fmt/format.h>

#include <cmath>

namespace raybundle::apps {
namespace {

using Json = nlohmann::ordered_json;

Json json_from_group(const ResidualGroup& group, const char* first, const char* second) {
  return {{"corners", group.corners},
          {"views", group.views},
          {first, group.mean_px.x()},
          {second, group.mean_px.y()},
          {"mean_sigma_px", group.mean_sigma_px},
          {"rms_px", group.rms_px}};
}

// `top left`, `middle`, ...
std::string place_text(const ResidualBias& bias, int part) {
  const int row = 3 * (part / bias.columns) / bias.rows, column = 3 * (part % bias.columns) / bias.columns;
  constexpr const char* kPlaces[3][3] = {
      {"top left", "top", "top right"}, {"left", "middle", "right"}, {"bottom left", "bottom", "bottom right"}};
  return kPlaces[row][column];
}

// The band whose radial mean chance explains least.
std::string band_text(const ResidualBias& bias) {
  constexpr double kFewestSigmas = 3.0;  // below, it is not worth a word
  const int strongest = bias.strongest_band();
  if (strongest < 0) return "";
  const ResidualGroup& band = bias.bands[static_cast<std::size_t>(strongest)];
  if (band.first_sigmas() <= kFewestSigmas) return "";
  const double degrees = bias.band_rad * 180.0 / M_PI;
  return fmt::format(", outwards by {:+.3f} px from {:.0f}° to {:.0f}° off the axis", band.mean_px.x(),
                     strongest * degrees, (strongest + 1) * degrees);
}

}  // namespace

Json json_from_bias(const ResidualBias& bias) {
  Json parts = Json::array();
  for (const ResidualGroup& part : bias.parts) parts.push_back(json_from_group(part, "mean_u_px", "mean_v_px"));
  Json bands = Json::array();
  for (std::size_t i = 0; i < bias.bands.size(); ++i) {
    Json band = json_from_group(bias.bands[i], "mean_outwards_px", "mean_around_px");
    band["from_deg"] = static_cast<double>(i) * bias.band_rad * 180.0 / M_PI;
    bands.push_back(band);
  }
  return {{"bias_px", bias.bias_px}, {"noise_px", bias.noise_px}, {"significant", bias.significant()},
          {"rows", bias.rows},       {"columns", bias.columns},   {"image_parts", parts},
          {"angle_bands", bands}};
}

std::string bias_text(const std::string& camera, const ResidualBias& bias) {
  if (!bias.significant()) {
    return fmt::format("{}: of {:.3f} px rms, noise is {:.3f} px; no part of the image shows bias beyond chance\n",
                       camera, bias.rms_px, bias.noise_px);
  }
  const ResidualGroup& part = bias.parts[static_cast<std::size_t>(bias.strongest)];
  return fmt::format(
      "{}: of {:.3f} px rms, noise is {:.3f} px and bias {:.3f} px: {} of the image by ({:+.3f}, {:+.3f}) px, {:.0f} "
      "sigmas of {} views{}\n",
      camera, bias.rms_px, bias.noise_px, bias.bias_px, place_text(bias, bias.strongest), part.mean_px.x(),
      part.mean_px.y(), bias.strongest_sigmas, part.views, band_text(bias));
}

}  // namespace raybundle::apps
