// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/io/observations_file.hpp"

#include <limits>
#include <set>

#include "image_side.hpp"
#include "json_laser.hpp"
#include "json_node.hpp"
#include "json_target.hpp"
#include "json_text.hpp"
#include "name_list.hpp"
#include "raybundle/scene/atomic_file.hpp"
#include "raybundle/scene/csv.hpp"
#include "raybundle/scene/suggestion.hpp"

namespace raybundle {
namespace {

constexpr const char* kFormat = "raybundle observations";
constexpr int kVersion = 1;

OrderedJson json_from_targets(const std::vector<Target>& targets) {
  OrderedJson json = OrderedJson::array();
  for (const Target& target : targets) {
    json.push_back(
        {{"name", target.name}, {"points", json_from_points(target)}, {"symmetries", json_from_symmetries(target)}});
  }
  return json;
}

OrderedJson json_from_cameras(const ObservationsFile& file) {
  OrderedJson json = OrderedJson::array();
  for (std::size_t i = 0; i < file.problem.cameras.size(); ++i) {
    const ProblemCamera& camera = file.problem.cameras[i];
    OrderedJson entry{{"name", camera.name}, {"width", camera.size.width}, {"height", camera.size.height}};
    if (i < file.models.size() && file.models[i]) entry["model"] = model_name(*file.models[i]);
    json.push_back(entry);
  }
  return json;
}

OrderedJson json_from_view(const CalibrationProblem& problem, const TargetView& view) {
  OrderedJson points = OrderedJson::array();
  for (const Observation& observation : view.observations) {
    points.push_back({observation.point_id, observation.pixel.x(), observation.pixel.y(), observation.sigma_px});
  }
  OrderedJson json{
      {"camera", problem.cameras[view.camera].name}, {"frame", problem.frames[view.frame]}, {"target", view.target}};
  if (!view.image.empty()) json["image"] = view.image;
  json["points"] = points;
  if (!view.dots.empty()) json["dots"] = json_from_dots(view.dots, problem.laser->grid);
  return json;
}

void read_cameras(const JsonNode& nodes, ObservationsFile& file) {
  std::set<std::string> names;
  for (std::size_t i = 0; i < nodes.array_size(); ++i) {
    const JsonNode node = nodes[i];
    node.expect_keys({"name", "width", "height", "model"});
    const JsonNode name = node.at("name");
    if (!names.insert(name.name()).second) name.fail(in_quotes(name.name()) + " stands twice; rename one camera");
    const auto model = node.find("model");
    file.models.push_back(model ? std::optional(model->model()) : std::nullopt);
    const ImageSize size{node.at("width").whole_number(0, kMaxImageSide_px),
                         node.at("height").whole_number(0, kMaxImageSide_px)};
    file.problem.cameras.push_back(
        {name.name(), file.models.back().value_or(ModelId{}), size, std::nullopt, std::nullopt});
  }
}

int index_of(const JsonNode& node, const NameList& list) {
  const std::string name = node.text();
  if (const auto index = list.find(name)) return *index;
  std::vector<std::string> known = list.names();
  if (known.size() > 20) known.resize(20);  // a message that lists a thousand frames helps nobody
  node.fail("names " + in_quotes(name) + ", which does not exist." + did_you_mean(name, known));
}

std::vector<Observation> observations_from(const JsonNode& rows, const Target& target) {
  std::vector<Observation> observations;
  observations.reserve(rows.array_size());
  std::set<int> ids;
  for (std::size_t i = 0; i < rows.array_size(); ++i) {
    const JsonNode row = rows[i];
    const std::size_t size = row.array_size();
    if (size != 3 && size != 4) row.fail("has " + std::to_string(size) + " entries; [id, u, v] or [id, u, v, sigma]");
    const int id = row[0].whole_number(0, std::numeric_limits<int>::max());
    if (target.find(id) == nullptr) {
      row.fail("is point " + std::to_string(id) + ", which target " + in_quotes(target.name) +
               " does not have; is the target right?");
    }
    if (!ids.insert(id).second) row.fail("is point " + std::to_string(id) + " again; give each point once a view");
    observations.push_back(
        {{row[1].number(), row[2].number()}, size == 4 ? row[3].positive_number() : Observation{}.sigma_px, id});
  }
  return observations;
}

/// What the views of a file refer to.
struct Named {
  NameList cameras, frames;
  bool frames_are_listed = false;
};

TargetView view_from(const JsonNode& node, Named& named, const CalibrationProblem& problem) {
  node.expect_keys({"camera", "frame", "target", "image", "points", "dots"});
  const JsonNode frame = node.at("frame");
  TargetView view;
  view.camera = index_of(node.at("camera"), named.cameras);
  view.frame = named.frames_are_listed ? index_of(frame, named.frames) : named.frames.index_of(frame.name());
  if (const auto target = node.find("target")) {
    view.target = target->whole_number(0, static_cast<int>(problem.targets.size()) - 1);
  }
  if (const auto image = node.find("image")) view.image = image->text();
  view.observations = observations_from(node.at("points"), problem.targets[view.target]);
  if (const auto dots = node.find("dots")) {
    if (!problem.laser) dots->fail("are there, but the file has no laser with rows and columns; add it");
    view.dots = dots_from(*dots, problem.laser->grid);
  }
  return view;
}

}  // namespace

std::string text_from_observations(const ObservationsFile& file) {
  OrderedJson views = OrderedJson::array();
  for (const TargetView& view : file.problem.views) views.push_back(json_from_view(file.problem, view));
  OrderedJson json{{"format", kFormat},
                   {"version", kVersion},
                   {"conventions",
                    {{"pixel", "(0, 0) is the centre of the top-left pixel"},
                     {"target_points", "id, x, y, z in metres"},
                     {"points", "id, u, v, sigma in pixels"}}},
                   {"targets", json_from_targets(file.problem.targets)},
                   {"cameras", json_from_cameras(file)},
                   {"frames", file.problem.frames}};
  if (file.problem.laser) {
    json["conventions"]["dots"] = "u, v, covariance uu, uv, vv in square pixels, row, column or null, brightness";
    json["laser"] = json_from_laser(*file.problem.laser);
  }
  json["views"] = views;
  return pretty_text(json, {"views"});
}

ObservationsFile observations_from_text(std::string_view text, const std::string& name) {
  LongJsonArray views{"views"};
  const JsonDocument document = parse_json(text, name, &views);
  const JsonNode root(document);
  expect_format(root, kFormat, kVersion);
  root.expect_keys({"format", "version", "conventions", "targets", "cameras", "frames", "laser", "views"});

  ObservationsFile file;
  const JsonNode targets = root.at("targets");
  for (std::size_t i = 0; i < targets.array_size(); ++i) {
    const JsonNode target = targets[i];
    target.expect_keys({"name", "points", "symmetries"});
    file.problem.targets.push_back(target_from(target));
  }
  if (file.problem.targets.empty()) targets.fail("is empty; there must be at least one target");
  read_cameras(root.at("cameras"), file);

  Named named;
  for (const ProblemCamera& camera : file.problem.cameras) named.cameras.index_of(camera.name);
  const auto listed = root.find("frames");
  named.frames_are_listed = listed.has_value();
  for (std::size_t i = 0; listed && i < listed->array_size(); ++i) {
    const JsonNode frame = (*listed)[i];
    if (named.frames.contains(frame.name())) frame.fail(in_quotes(frame.text()) + " stands twice; rename one frame");
    named.frames.index_of(frame.text());
  }
  if (const auto laser = root.find("laser")) file.problem.laser = laser_from(*laser);
  const JsonNode nodes = root.at("views");
  for (std::size_t i = 0; i < nodes.array_size(); ++i) {
    file.problem.views.push_back(view_from(nodes[i], named, file.problem));
  }
  for (std::size_t i = 0; i < views.entries.size(); ++i) {
    const nlohmann::json value = nlohmann::json::parse(views.entries[i].begin(), views.entries[i].end());
    file.problem.views.push_back(view_from(nodes.entry(i, value), named, file.problem));
  }
  file.problem.frames = named.frames.names();
  check_as_part_of(name, file.problem);
  return file;
}

void write_observations(const std::filesystem::path& path, const ObservationsFile& file) {
  write_file_whole(path, text_from_observations(file));
}

ObservationsFile read_observations(const std::filesystem::path& path) {
  return observations_from_text(text_of_file(path), path.string());
}

}  // namespace raybundle
