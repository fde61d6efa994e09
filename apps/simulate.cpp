// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "beam_grid.hpp"
#include "dataset.hpp"
#include "number_flags.hpp"
#include "output_folder.hpp"
#include "page_text.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/atomic_file.hpp"
#include "simulated_files.hpp"
#include "simulated_images.hpp"
#include "terminal.hpp"
#include "verbs.hpp"

namespace raybundle::apps {
namespace {

struct SimulateFlags {
  std::string rig;
  std::string output;
  SimulateOptions options{.labelled = false};
  std::string beams;
  std::optional<double> turn_deg;
  bool images = true;
  int threads = CalibrateOptions{}.threads;
  bool json = false;
};

// What was typed, to be typed again.
std::string command_of(const SimulateFlags& flags) {
  const SimulateOptions& options = flags.options;
  const SimulateOptions usual;
  std::string command =
      fmt::format("raybundle simulate {} --frames {} --seed {}", shell_word(flags.rig), options.frames, options.seed);
  const auto add = [&command](const char* flag, double value, double usual_value) {
    if (value != usual_value) command += fmt::format(" {} {}", flag, value);
  };
  if (!flags.beams.empty()) command += " --beams " + flags.beams;
  if (flags.turn_deg) command += fmt::format(" --turn {}", *flags.turn_deg);
  add("--corner-sigma", options.corner_sigma_px, usual.corner_sigma_px);
  add("--dot-sigma", options.dot_sigma_px, usual.dot_sigma_px);
  add("--missed", options.missed, usual.missed);
  add("--spurious", options.spurious, usual.spurious);
  add("--warmer", options.warmer_K, usual.warmer_K);
  if (options.labelled) command += " --labelled";
  if (!flags.images) command += " --no-images";
  return command + " -o " + shell_word(flags.output);
}

void change_emitter(const SimulateFlags& flags, SimulatedRig& rig) {
  if (flags.beams.empty() && !flags.turn_deg && flags.options.warmer_K == 0.0) return;
  if (!rig.emitter) {
    throw Error(ErrorKind::kBadInput,
                "--beams, --turn and --warmer are for rigs with an [emitter], and this one has none", flags.rig);
  }
  if (!flags.beams.empty()) {
    const LaserGrid grid = beam_grid_from_flag(flags.beams);
    if (grid.rows != rig.emitter->grid.rows || grid.columns != rig.emitter->grid.columns) set_grid(*rig.emitter, grid);
  }
  if (flags.turn_deg) rig.emitter->lattice_turn_rad = *flags.turn_deg * M_PI / 180.0;
}

struct Counts {
  std::size_t views = 0, corners = 0, dots = 0;
};

Counts counts_of(const CalibrationProblem& problem, int camera) {
  Counts counts;
  for (const TargetView& view : problem.views) {
    if (view.camera != camera) continue;
    ++counts.views;
    counts.corners += view.observations.size();
    counts.dots += view.dots.size();
  }
  return counts;
}

void print_summary(const SimulateFlags& flags, const Simulation& simulation) {
  std::vector<std::vector<std::string>> rows{{"camera", "views", "corners", "dots"}};
  for (int c = 0; c < static_cast<int>(simulation.problem.cameras.size()); ++c) {
    const Counts counts = counts_of(simulation.problem, c);
    rows.push_back({simulation.problem.cameras[c].name, fmt::format("{}", counts.views),
                    fmt::format("{}", counts.corners), fmt::format("{}", counts.dots)});
  }
  fmt::print("{}", text_table(rows));
  if (simulation.truth.laser) {
    const std::vector<LaserBeam>& beams = simulation.truth.laser->beams;
    const auto poor = std::ranges::count_if(
        beams, [](const LaserBeam& beam) { return beam.hits < 4 || beam.farthest_hit_m - beam.nearest_hit_m < 0.3; });
    fmt::print("{} beams, {} of them with fewer than 4 hits or less than 0.3 m between the nearest and the farthest\n",
               beams.size(), poor);
  }
  fmt::print("\nwrote {}\nnext  raybundle calibrate {} -o out\n", flags.output,
             flags.images ? shell_word(flags.output + "/dataset.toml")
                          : "--observations " + shell_word(flags.output + "/observations.json"));
}

void print_json(const SimulateFlags& flags, const Simulation& simulation) {
  nlohmann::ordered_json cameras = nlohmann::ordered_json::array();
  for (int c = 0; c < static_cast<int>(simulation.problem.cameras.size()); ++c) {
    const Counts counts = counts_of(simulation.problem, c);
    cameras.push_back({{"name", simulation.problem.cameras[c].name},
                       {"views", counts.views},
                       {"corners", counts.corners},
                       {"dots", counts.dots}});
  }
  const nlohmann::ordered_json result{{"folder", flags.output}, {"command", command_of(flags)}, {"cameras", cameras}};
  fmt::print("{}\n", text_of_json(result, 2));
}

void run(const SimulateFlags& flags) {
  namespace fs = std::filesystem;
  const std::string command = command_of(flags);
  BoardedRig boarded = rig_of(flags.rig);
  change_emitter(flags, boarded.rig);
  if (flags.images) require_images(boarded);
  require_writable(flags.output);
  Simulation simulation = simulate(boarded.rig, flags.options);
  if (flags.images) {
    for (TargetView& view : simulation.problem.views) {
      view.image = simulated_image(simulation.problem.cameras[view.camera].name, view.frame, false);
    }
  }
  const fs::path folder(flags.output);
  write_simulation(folder, simulation, command);
  remove_former_images(folder, boarded.rig.cameras);
  std::error_code ignored;
  fs::remove(folder / "dataset.toml", ignored);  // of a former run: it would name images that are no more
  if (flags.images) {
    write_images(folder, boarded, simulation, flags.options, flags.threads);
    const ProblemLaser* laser = simulation.problem.laser ? &*simulation.problem.laser : nullptr;
    write_file_whole(folder / "dataset.toml", dataset_text(boarded, laser, command));
  }
  flags.json ? print_json(flags, simulation) : print_summary(flags, simulation);
}

}  // namespace

void add_simulate_verb(CLI::App& app) {
  auto flags = std::make_shared<SimulateFlags>();
  SimulateOptions& options = flags->options;
  CLI::App* verb = app.add_subcommand("simulate", "a rig description -> images, observations and the truth");
  verb->add_option("rig", flags->rig, "the rig description (docs/formats/rig.md), or random:SEED")->required();
  verb->add_option("-o,--output", flags->output, "folder to write")->type_name("DIR")->required();
  verb->add_option("--frames", options.frames, "poses of the board")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  verb->add_option("--seed", options.seed, "same seed, same bits")
      ->check(CLI::Range(std::uint64_t{0}, kMostSeed))
      ->capture_default_str();
  verb->add_option("--beams", flags->beams, "another grid of laser beams in the same field, as 19x16")
      ->type_name("COLUMNSxROWS");
  verb->add_option("--turn", flags->turn_deg, "of the grid of beams against the baseline [deg]");
  verb->add_option("--corner-sigma", options.corner_sigma_px, "noise of corners, each coordinate [px]")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  verb->add_option("--dot-sigma", options.dot_sigma_px, "noise of dots, each coordinate [px]")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  verb->add_option("--missed", options.missed, "share of the dots that are not found")->check(CLI::Range(0.0, 1.0));
  verb->add_option("--spurious", options.spurious, "false dots, over the true ones")->check(CLI::Range(0.0, 1.0));
  verb->add_option("--warmer", options.warmer_K, "the laser's temperature above the nominal one [K]")
      ->check(CLI::Range(-100.0, 100.0));
  verb->add_flag("--labelled", options.labelled, "dots in observations.json carry their row and column");
  verb->add_flag("!--no-images", flags->images, "observations only");
  verb->add_option("--threads", flags->threads, "worker threads; images do not depend on them")
      ->check(CLI::Range(1, kMostThreads))
      ->capture_default_str();
  verb->add_flag("--json", flags->json, "print the result as JSON");
  verb->footer(
      "Example:\n"
      "  raybundle simulate datasets/rigs/rig_26mm_laser.toml --frames 60 --seed 7 --beams 19x16 -o sim\n"
      "  raybundle calibrate sim/dataset.toml -o out                          # from the images\n"
      "  raybundle calibrate --observations sim/observations.json -o out      # from the observations");
  verb->callback([flags] { run(*flags); });
}

}  // namespace raybundle::apps
