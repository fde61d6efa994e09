// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>

#include "beam_grid.hpp"
#include "occupancy_classify.hpp"
#include "occupancy_evaluation.hpp"
#include "occupancy_learning.hpp"
#include "output_folder.hpp"
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
  bool beams_given = false, json = false;
};

SensorKind kind_of(const std::string& sensor) {
  return sensor == "stereo" ? SensorKind::kStereo : SensorKind::kStructuredLight;
}

void refuse_beams_of_stereo(const Flags& flags, SensorKind kind) {
  if (!flags.beams_given || kind != SensorKind::kStereo) return;
  throw Error(ErrorKind::kBadInput, "--beams are of a laser, and stereo has none; leave it out");
}

// Calls `work` with what it is to call after each scene, from any thread.
template <typename Work>
auto with_progress(const std::string& what, int scenes, const Work& work) {
  Progress progress(what, scenes);
  std::mutex guard;
  return work([&] {
    const std::scoped_lock lock(guard);
    progress.advance();
  });
}

LabelledCases cases_with_progress(SimulatedLearning learning) {
  return with_progress("simulating", learning.scenes, [&](const std::function<void()>& scene_done) {
    learning.scene_done = scene_done;
    return simulated_cases(learning);
  });
}

Evaluation evaluate_with_progress(const CaseBase& base, EvaluationOptions options, const std::string& vehicles) {
  return with_progress(vehicles + " vehicles", options.scenes, [&](const std::function<void()>& scene_done) {
    options.scene_done = scene_done;
    return evaluate(base, options);
  });
}

void run_learn(Flags flags) {
  flags.learning.kind = kind_of(flags.sensor);
  refuse_beams_of_stereo(flags, flags.learning.kind);
  flags.learning.scenes = flags.scenes > 0 ? flags.scenes : learning_of(flags.learning.kind).scenes;
  flags.learning.grid = beam_grid_from_flag(flags.grid);
  if (flags.learning.seed + static_cast<std::uint64_t>(flags.learning.scenes) > kEvaluationSeed) {
    throw Error(ErrorKind::kBadInput, fmt::format("--seed and --scenes reach {}, from where on scenes are kept for "
                                                  "`occupancy evaluate`; take a smaller seed",
                                                  kEvaluationSeed));
  }
  require_writable_file(flags.output, "-o");
  require_votes(flags.learning, flags.learn.neighbours);
  flags.learn.threads = flags.learning.threads;
  const CaseBase base = learn(cases_with_progress(flags.learning), flags.learn);
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
      100 * base.sure_of_situation, flags.output, shell_word(flags.output));
}

// Simulated cabins have classes and groups of their own, in an order of their own.
void require_cabin_classes(const CaseBase& base, const std::string& path) {
  std::vector<std::string> names, known;
  for (const SituationClass& situation : base.situations) names.push_back(situation.name);
  for (const SituationClass& situation : cabin_situations()) known.push_back(situation.name);
  if (names == known && base.group_names == cabin_groups()) return;
  throw Error(ErrorKind::kBadInput,
              "has other classes or groups than simulated cabins, which alone it could be evaluated on", path);
}

void run_evaluate(Flags flags) {
  const CaseBase base = case_base_from_bytes(text_of_file(flags.base), flags.base);
  require_cabin_classes(base, flags.base);
  EvaluationOptions& options = flags.evaluation;
  options.kind = sensor_kind_of(base);
  refuse_beams_of_stereo(flags, options.kind);
  options.monitor = monitor_options_of(options.kind);
  options.grid = beam_grid_from_flag(flags.grid);
  options.seed += kEvaluationSeed;
  std::vector<std::pair<std::string, Evaluation>> evaluations;
  for (const auto& [name, generator] :
       {std::pair("same", CockpitGenerator::kTraining), {"held-out", CockpitGenerator::kTest}}) {
    if (flags.split != "both" && flags.split != name) continue;
    options.generator = generator;
    evaluations.emplace_back(name, evaluate_with_progress(base, options, name));
    if (!flags.json)
      fmt::print("{}\n", text_from_evaluation(fmt::format("{} vehicles", name), evaluations.back().second));
  }
  if (flags.json) fmt::print("{}\n", json_from_evaluations(evaluations));
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
          fmt::format("simulated by the training generator; {} of the laser or {} of stereo unless said; a quarter "
                      "votes, among which each class needs more than --neighbours",
                      learning_of(SensorKind::kStructuredLight).scenes, learning_of(SensorKind::kStereo).scenes))
      ->check(CLI::Range(100, kMostScenes));
  learn->add_option("--seed", flags->learning.seed, "of the first scene")
      ->check(CLI::Range(std::uint64_t{0}, kEvaluationSeed))
      ->capture_default_str();
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
  learn->footer(
      "Scenes of stereo are rendered, which takes the better part of an hour; those of a laser take minutes. Fewer\n"
      "--scenes do for a trial, more --threads divide the time.");
  learn->callback([flags, learn] {
    flags->beams_given = learn->count("--beams") > 0;
    run_learn(*flags);
  });
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
  evaluate->callback([flags, evaluate] {
    flags->beams_given = evaluate->count("--beams") > 0;
    run_evaluate(*flags);
  });
}

}  // namespace

void add_occupancy_verb(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("occupancy", "3-D -> who is on the seat, and what the airbag may do");
  verb->require_subcommand(1);
  add_learn(*verb);
  add_occupancy_classify(*verb);
  add_evaluate(*verb);
  verb->footer(
      "Example:\n"
      "  raybundle occupancy learn --scenes 40000 --threads 4 -o seats.rbcases\n"
      "  raybundle occupancy evaluate seats.rbcases --scenes 3000\n"
      "  raybundle reconstruct structured-light out/calibration.json 'frames/*.png' -o points\n"
      "  raybundle occupancy classify seats.rbcases points --vehicle vehicle.toml --page seats.html");
}

}  // namespace raybundle::apps
