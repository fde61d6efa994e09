// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "laser_frame_files.hpp"
#include "occupancy_evaluation.hpp"
#include "occupancy_input.hpp"
#include "occupancy_learning.hpp"
#include "occupancy_page.hpp"
#include "page_text.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/occupancy/case_base_file.hpp"
#include "raybundle/scene/atomic_file.hpp"
#include "raybundle/scene/csv.hpp"
#include "terminal.hpp"
#include "verbs.hpp"

namespace raybundle::apps {
namespace {

constexpr int kMostScenes = 1000000;
// Scenes of the training generator that are evaluated have seeds from here on; learnt ones stay below.
constexpr std::uint64_t kEvaluationSeed = 1000000000;

struct Flags {
  std::string base, output, sensor = "structured-light", grid = "11x11", split = "both";
  int scenes = 0;
  SimulatedLearning learning;
  LearnOptions learn;
  EvaluationOptions evaluation;
  std::string vehicle, page;
  std::vector<std::string> frames;
  bool json = false;
};

SensorKind kind_of(const std::string& sensor) {
  return sensor == "stereo" ? SensorKind::kStereo : SensorKind::kStructuredLight;
}

LaserGrid grid_of(const std::string& word) {
  int columns = 0, rows = 0, end = 0;
  const bool read = std::sscanf(word.c_str(), "%2dx%2d%n", &columns, &rows, &end) == 2;
  if (!read || end != static_cast<int>(word.size()) || columns < 2 || rows < 2 || columns > 64 || rows > 64) {
    throw Error(ErrorKind::kBadInput,
                fmt::format("--beams {} is not COLUMNSxROWS of 2 to 64 beams, as in 11x11", word));
  }
  return {rows, columns};
}

void run_learn(Flags flags) {
  flags.learning.kind = kind_of(flags.sensor);
  flags.learning.scenes = flags.scenes > 0 ? flags.scenes : learning_of(flags.learning.kind).scenes;
  flags.learning.grid = grid_of(flags.grid);
  if (flags.learning.seed + static_cast<std::uint64_t>(flags.learning.scenes) > kEvaluationSeed) {
    throw Error(ErrorKind::kBadInput, fmt::format("--seed and --scenes reach {}, from where on scenes are kept for "
                                                  "`occupancy evaluate`; take a smaller seed",
                                                  kEvaluationSeed));
  }
  flags.learn.threads = flags.learning.threads;
  const CaseBase base = learn(simulated_cases(flags.learning), flags.learn);
  write_file_whole(flags.output, bytes_from_case_base(base));
  if (flags.json) {
    fmt::print("{}\n", text_of_json(nlohmann::ordered_json{{"base", flags.output},
                                                           {"cases", base.classes.size()},
                                                           {"sure_of_group", base.sure_of_group},
                                                           {"sure_of_class", base.sure_of_situation}}));
    return;
  }
  fmt::print(
      "learnt from {} scenes; {} of them vote, attributes {}\n"
      "groups are told from {:.1f} % of the votes on, classes from {:.1f} %\nwrote {}\nnext  raybundle occupancy "
      "evaluate {}\n",
      flags.learning.scenes, base.classes.size(), base.attribute_set, 100 * base.sure_of_group,
      100 * base.sure_of_situation, flags.output, flags.output);
}

void run_evaluate(Flags flags) {
  const CaseBase base = case_base_from_bytes(text_of_file(flags.base), flags.base);
  EvaluationOptions& options = flags.evaluation;
  options.kind = base.attribute_set == kBoxes.name ? SensorKind::kStereo : SensorKind::kStructuredLight;
  options.monitor = monitor_options_of(options.kind);
  options.grid = grid_of(flags.grid);
  options.seed += kEvaluationSeed;
  std::vector<std::pair<std::string, Evaluation>> evaluations;
  for (const auto& [name, generator] :
       {std::pair("same", CockpitGenerator::kTraining), {"held-out", CockpitGenerator::kTest}}) {
    if (flags.split != "both" && flags.split != name) continue;
    options.generator = generator;
    evaluations.emplace_back(name, evaluate(base, options));
    if (!flags.json)
      fmt::print("{}\n", text_from_evaluation(fmt::format("{} vehicles", name), evaluations.back().second));
  }
  if (flags.json) fmt::print("{}\n", json_from_evaluations(evaluations));
}

std::string name_of(AirbagAction action) {
  constexpr const char* kNames[kAirbagActions] = {"undecided", "no_fire", "depowered", "fire"};
  return kNames[static_cast<std::size_t>(action)];
}

nlohmann::ordered_json json_of(const std::string& file, const Occupancy& answer, const CaseBase& base) {
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

nlohmann::ordered_json json_of(const VehicleLayout& layout) {
  return {{"dashboard_x_m", layout.dashboard_x_m},
          {"zone_floor_m", layout.zone_floor_m},
          {"zone_half_width_m", layout.zone_half_width_m},
          {"critical_m", layout.critical_m},
          {"out_of_position_m", layout.out_of_position_m}};
}

nlohmann::ordered_json json_of(const std::vector<ScenePoint>& points) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const ScenePoint& point : points) {
    const Eigen::Vector3d& x = point.x_in_vehicle;
    json.push_back({{"ray", point.ray}, {"x_in_vehicle_m", {x.x(), x.y(), x.z()}}, {"sigma_m", point.sigma_m}});
  }
  return json;
}

void run_classify(const Flags& flags) {
  const CaseBase base = case_base_from_bytes(text_of_file(flags.base), flags.base);
  const InstalledSensor sensor = read_installed_sensor(flags.vehicle);
  if (base.attribute_set != kStripes.name) {
    throw Error(ErrorKind::kBadInput,
                "was learnt for stereo, and the points are of a laser; learn one for "
                "structured-light",
                flags.base);
  }
  OccupancyMonitor monitor(sensor.layout, base, sensor.rays(), monitor_options_of(SensorKind::kStructuredLight));
  nlohmann::ordered_json frames = nlohmann::ordered_json::array(), shown = frames;
  std::vector<std::vector<std::string>> rows{{"frame", "state", "airbag", "group", "class", "distance m"}};
  for (const std::string& file : flags.frames) {
    const PointFrame frame = read_point_frame(file, sensor);
    const Occupancy answer = monitor.process({sensor.viewpoint_in_vehicle, frame.points, sensor.rays(), frame.state});
    frames.push_back(json_of(file, answer, base));
    if (!flags.page.empty()) {
      shown.push_back(frames.back());
      shown.back()["points"] = json_of(frame.points);
    }
    rows.push_back({file, state_name(answer.state), name_of(answer.action),
                    answer.group < 0 ? "unsure" : base.group_names[answer.group],
                    answer.situation < 0 ? "unknown" : base.situations[answer.situation].name,
                    answer.zones.anything ? fmt::format("{:.3f}", answer.zones.distance_m) : "-"});
  }
  if (!flags.page.empty()) {
    const nlohmann::ordered_json page{{"vehicle", json_of(sensor.layout)}, {"frames", shown}};
    write_file_whole(flags.page, occupancy_page(text_of_json(page)));
  }
  flags.json ? fmt::print("{}\n", text_of_json(nlohmann::ordered_json{{"frames", frames}}, 2))
             : fmt::print("{}", text_table(rows));
}

void add_classify(CLI::App& verb) {
  auto flags = std::make_shared<Flags>();
  CLI::App* classify = verb.add_subcommand("classify", "laser points of one or more frames, in their order");
  classify->add_option("base", flags->base, "what `occupancy learn` wrote")->required();
  classify->add_option("points", flags->frames, "JSON of `reconstruct structured-light`")->required();
  classify->add_option("--vehicle", flags->vehicle, "where seat, dashboard and sensor are (docs/formats/occupancy.md)")
      ->type_name("TOML")
      ->required();
  classify->add_option("--page", flags->page, "an HTML page of the frames to write")->type_name("FILE");
  classify->add_flag("--json", flags->json, "print the result as JSON");
  classify->callback([flags] { run_classify(*flags); });
}

void add_learn(CLI::App& verb) {
  auto flags = std::make_shared<Flags>();
  CLI::App* learn = verb.add_subcommand("learn", "make a base of learnt cases");
  learn->add_option("-o,--output", flags->output, "the base to write")->type_name("FILE")->required();
  learn->add_option("--sensor", flags->sensor, "whose points are learnt")
      ->check(CLI::IsMember({"structured-light", "stereo"}))
      ->capture_default_str();
  learn->add_option("--beams", flags->grid, "of the laser")->type_name("COLUMNSxROWS")->capture_default_str();
  learn
      ->add_option(
          "--scenes", flags->scenes,
          fmt::format("simulated by the training generator; {} of the laser or {} of stereo unless said",
                      learning_of(SensorKind::kStructuredLight).scenes, learning_of(SensorKind::kStereo).scenes))
      ->check(CLI::Range(100, kMostScenes));
  learn->add_option("--seed", flags->learning.seed, "of the first scene")->capture_default_str();
  learn->add_option("--other-cars", flags->learning.other_cars, "copies of each scene as if in another car")
      ->check(CLI::Range(0, 20))
      ->capture_default_str();
  learn->add_option("--neighbours", flags->learn.neighbours, "that vote")
      ->check(CLI::Range(1, kMostNeighbours))
      ->capture_default_str();
  learn->add_option("--threads", flags->learning.threads, "the base does not depend on them")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  learn->add_flag("--json", flags->json, "print the result as JSON");
  learn->callback([flags] { run_learn(*flags); });
}

void add_evaluate(CLI::App& verb) {
  auto flags = std::make_shared<Flags>();
  EvaluationOptions& options = flags->evaluation;
  CLI::App* evaluate = verb.add_subcommand("evaluate", "a base on simulated scenes that it has not seen");
  evaluate->add_option("base", flags->base, "what `occupancy learn` wrote")->required();
  evaluate->add_option("--split", flags->split, "vehicles like the learnt ones, others, or both")
      ->check(CLI::IsMember({"same", "held-out", "both"}))
      ->capture_default_str();
  evaluate->add_option("--beams", flags->grid, "of the laser")->type_name("COLUMNSxROWS")->capture_default_str();
  evaluate->add_option("--scenes", options.scenes, "of each split")
      ->check(CLI::Range(1, kMostScenes))
      ->capture_default_str();
  evaluate->add_option("--seed", options.seed, "other scenes")
      ->check(CLI::Range(0, kMostScenes))
      ->capture_default_str();
  evaluate->add_option("--frames", options.frames, "of each scene, 0.1 s apart; the last one is judged")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  evaluate->add_option("--threads", options.threads, "figures do not depend on them")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  evaluate->add_flag("--json", flags->json, "print the result as JSON");
  evaluate->callback([flags] { run_evaluate(*flags); });
}

}  // namespace

void add_occupancy_verb(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("occupancy", "3-D -> who is on the seat, and what the airbag may do");
  verb->require_subcommand(1);
  add_learn(*verb);
  add_classify(*verb);
  add_evaluate(*verb);
  verb->footer(
      "Example:\n"
      "  raybundle occupancy learn --scenes 40000 --threads 4 -o seats.rbcases\n"
      "  raybundle occupancy evaluate seats.rbcases --scenes 3000\n"
      "  raybundle reconstruct structured-light out/calibration.json frames/*.png -o points\n"
      "  raybundle occupancy classify seats.rbcases points/*.json --vehicle vehicle.toml --page seats.html");
}

}  // namespace raybundle::apps
