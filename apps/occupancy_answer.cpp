// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "occupancy_answer.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "state_name.hpp"

namespace raybundle::apps {
namespace {

std::string name_of(AirbagAction action) {
  constexpr const char* kNames[kAirbagActions] = {"undecided", "no_fire", "depowered", "fire"};
  return kNames[static_cast<std::size_t>(action)];
}

}  // namespace

nlohmann::ordered_json json_of_answer(const std::string& file, const Occupancy& answer, const CaseBase& base) {
  nlohmann::ordered_json json{{"file", file}, {"state", state_name(answer.state)}, {"airbag", name_of(answer.action)}};
  json["group"] = answer.group < 0 ? nlohmann::ordered_json() : nlohmann::ordered_json(base.group_names[answer.group]);
  json["class"] =
      answer.situation < 0 ? nlohmann::ordered_json() : nlohmann::ordered_json(base.situations[answer.situation].name);
  json["confidence"] = answer.confidence;
  json["points_in_critical_zone"] = answer.zones.critical;
  json["points_in_outer_zone"] = answer.zones.out_of_position;
  if (answer.zones.anything) json["dashboard_distance_m"] = answer.zones.distance_m;
  if (answer.zones.anything) json["dashboard_distance_sigma_m"] = answer.zones.sigma_m;
  json["rays_through_zones"] = answer.free_rays;
  json["moving"] = answer.moving;
  return json;
}

std::vector<std::string> head_of_answers() { return {"frame", "state", "airbag", "group", "class", "distance m"}; }

std::vector<std::string> row_of_answer(const std::string& file, const Occupancy& answer, const CaseBase& base) {
  return {file,
          state_name(answer.state),
          name_of(answer.action),
          answer.group < 0 ? "unsure" : base.group_names[answer.group],
          answer.situation < 0 ? "unknown" : base.situations[answer.situation].name,
          answer.zones.anything ? fmt::format("{:.3f}", answer.zones.distance_m) : "-"};
}

}  // namespace raybundle::apps
