// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "cockpit_files.hpp"
#include "number_flags.hpp"
#include "output_folder.hpp"
#include "page_text.hpp"
#include "pose_json.hpp"
#include "raybundle/cockpit/cabin_renderer.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "raybundle/scene/atomic_file.hpp"
#include "simulated_images.hpp"
#include "terminal.hpp"
#include "verbs.hpp"

namespace raybundle::apps {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr int kMostScenes = 100000, kMostFrames = 1000;
constexpr double kFrame_s = 0.1;  // from a frame to the next

struct SimulateCockpitFlags {
  std::string output, generator = "training", sensor = "structured-light", wanted;
  std::uint64_t seed = 1;
  int scenes = 8, frames = 1, rows = 11, columns = 11, size = 128;
  bool json = false;
};

// How the flags would be typed again.
std::string command_of(const SimulateCockpitFlags& flags) {
  std::string command =
      fmt::format("raybundle simulate-cockpit --generator {} --sensor {} --scenes {} --frames {} --seed {}",
                  flags.generator, flags.sensor, flags.scenes, flags.frames, flags.seed);
  command += flags.sensor == "stereo" ? fmt::format(" --size {}", flags.size)
                                      : fmt::format(" --rows {} --columns {}", flags.rows, flags.columns);
  if (!flags.wanted.empty()) command += " --class " + flags.wanted;
  return command + " -o " + shell_word(flags.output);
}

// What makes points of the images.
std::string next_command(const SimulateCockpitFlags& flags) {
  const auto in_folder = [&](const char* name) { return shell_word((fs::path(flags.output) / name).string()); };
  const bool stereo = flags.sensor == "stereo";
  return fmt::format("raybundle reconstruct {} {} {} {} -o points", flags.sensor, in_folder("calibration.json"),
                     in_folder(stereo ? "*_left.png" : "*_on.png"),
                     stereo ? in_folder("*_right.png") : "--off " + in_folder("*_off.png"));
}

CabinSensor sensor_of(const SimulateCockpitFlags& flags, CockpitGenerator generator) {
  if (flags.sensor == "stereo") return stereo_sensor(generator, flags.seed, {flags.size, flags.size});
  return structured_light_sensor(generator, flags.seed, {flags.rows, flags.columns});
}

std::optional<CabinClass> wanted_of(const SimulateCockpitFlags& flags, int scene) {
  if (flags.wanted.empty()) return static_cast<CabinClass>(scene % kCabinClasses);
  return static_cast<CabinClass>(std::ranges::find(kCabinClassNames, flags.wanted) - kCabinClassNames.begin());
}

// Renders one frame; names of its images by camera, or off and on.
ordered_json write_frame(const fs::path& folder, const CabinRenderer& renderer, const CabinScene& scene,
                         const std::string& stem, const CabinImageOptions& options) {
  ordered_json names;
  const auto write = [&](const std::string& key, int camera, bool laser) {
    const std::string name = fmt::format("{}_{}.png", stem, key);
    CabinImageOptions these = options;
    these.laser = laser;
    write_png(folder / name, renderer.image(scene, camera, these));
    names[key] = name;
  };
  if (renderer.sensor().rig.emitter) {
    write("off", 0, false);
    write("on", 0, true);
  } else {
    for (int camera = 0; camera < 2; ++camera) write(renderer.sensor().rig.cameras[camera].name, camera, false);
  }
  return names;
}

ordered_json write_scenes(const SimulateCockpitFlags& flags, const fs::path& folder, CockpitGenerator generator,
                          const CabinRenderer& renderer) {
  ordered_json scenes = ordered_json::array();
  Progress progress("rendering", flags.scenes * flags.frames);
  for (int s = 0; s < flags.scenes; ++s) {
    ordered_json frames = ordered_json::array();
    CabinLayout layout;
    const std::uint64_t seed = flags.seed + static_cast<std::uint64_t>(s);
    for (int f = 0; f < flags.frames; ++f) {
      const double time_s = kFrame_s * f;
      const CabinScene scene(make_cockpit({generator, seed, wanted_of(flags, s), time_s}));
      const ordered_json images = write_frame(folder, renderer, scene, cockpit_frame_name(s, f),
                                              {.seed = seed, .stream = static_cast<std::uint64_t>(f)});
      layout = scene.cockpit().layout;
      frames.push_back({{"time_s", time_s}, {"images", images}, {"truth", json_from_truth(scene.cockpit().truth)}});
      progress.advance();
    }
    write_file_whole(folder / vehicle_file_name(s), vehicle_toml(layout, renderer.sensor()));
    scenes.push_back({{"seed", seed},
                      {"vehicle_file", vehicle_file_name(s)},
                      {"vehicle", json_from_layout(layout)},
                      {"frames", frames}});
  }
  return scenes;
}

// A flag of the other sensor would change nothing.
void refuse_flags_of_other_sensor(const CLI::App& verb, const std::string& sensor) {
  const bool stereo = sensor == "stereo";
  for (const char* flag : stereo ? std::vector{"--rows", "--columns"} : std::vector{"--size"}) {
    if (verb.count(flag) == 0) continue;
    throw Error(ErrorKind::kBadInput, fmt::format("{} is of --sensor {}, and this is {}; leave it out", flag,
                                                  stereo ? "structured-light" : "stereo", sensor));
  }
}

void run(const SimulateCockpitFlags& flags) {
  const fs::path folder(flags.output);
  require_writable(folder);
  const auto generator = flags.generator == "test" ? CockpitGenerator::kTest : CockpitGenerator::kTraining;
  const CabinRenderer renderer(sensor_of(flags, generator));
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error) fs::remove(folder / "scenes.json", error);  // it stands for a folder that is whole
  if (error) {
    throw Error(ErrorKind::kIo, fmt::format("the output folder {} cannot be prepared: {}; choose another with -o",
                                            flags.output, error.message()));
  }
  const ordered_json scenes = write_scenes(flags, folder, generator, renderer);
  remove_former_files(folder, scenes);
  CalibrationFile calibration;
  calibration.calibration = calibration_of(renderer.sensor());
  calibration.provenance.command = command_of(flags);
  calibration.provenance.versions = {{"raybundle", RAYBUNDLE_VERSION}};
  write_calibration(folder / "calibration.json", calibration);
  const ordered_json index{{"format", "raybundle-cockpit-scenes"},
                           {"version", 1},
                           {"command", command_of(flags)},
                           {"generator", flags.generator},
                           {"sensor", flags.sensor},
                           {"vehicle_from_rig", json_from_pose(renderer.sensor().known_vehicle_from_rig)},
                           {"true_vehicle_from_rig", json_from_pose(renderer.sensor().vehicle_from_rig)},
                           {"scenes", scenes}};
  write_file_whole(folder / "scenes.json", text_of_json(index, 1) + "\n");
  if (flags.json) {
    const ordered_json result{{"folder", flags.output}, {"command", command_of(flags)}, {"scenes", flags.scenes}};
    fmt::print("{}\n", text_of_json(result, 2));
  } else {
    fmt::print("{} scenes of {} frames, seen by {}\nwrote {}\nnext  {}\n", flags.scenes, flags.frames, flags.sensor,
               flags.output, next_command(flags));
  }
}

}  // namespace

void add_simulate_cockpit_verb(CLI::App& app) {
  auto flags = std::make_shared<SimulateCockpitFlags>();
  CLI::App* verb =
      app.add_subcommand("simulate-cockpit", "vehicle cabins -> images of a sensor in them, and the truth");
  verb->add_option("-o,--output", flags->output, "folder to write")->type_name("DIR")->required();
  verb->add_option("--generator", flags->generator, "whose cars, bodies and things: training or test")
      ->check(CLI::IsMember({"training", "test"}))
      ->capture_default_str();
  verb->add_option("--sensor", flags->sensor, "structured-light or stereo")
      ->check(CLI::IsMember({"structured-light", "stereo"}))
      ->capture_default_str();
  verb->add_option("--class", flags->wanted, "of all scenes; else the classes take turns")
      ->check(CLI::IsMember(std::vector<std::string>(kCabinClassNames.begin(), kCabinClassNames.end())));
  verb->add_option("--scenes", flags->scenes, "cabins")->check(CLI::Range(1, kMostScenes))->capture_default_str();
  verb->add_option("--frames", flags->frames, "of each cabin, 0.1 s apart; passengers move")
      ->check(CLI::Range(1, kMostFrames))
      ->capture_default_str();
  verb->add_option("--seed", flags->seed, "of the first scene and of the sensor; same seed, same bits")
      ->check(CLI::Range(std::uint64_t{0}, kMostSeed))
      ->capture_default_str();
  verb->add_option("--rows", flags->rows, "of laser beams")->check(CLI::Range(2, 64))->capture_default_str();
  verb->add_option("--columns", flags->columns, "of laser beams")->check(CLI::Range(2, 64))->capture_default_str();
  verb->add_option("--size", flags->size, "of stereo images, each way [px]")
      ->check(CLI::Range(32, 2048))
      ->capture_default_str();
  verb->add_flag("--json", flags->json, "print the result as JSON");
  verb->footer(
      "Example:\n"
      "  raybundle simulate-cockpit --sensor stereo --scenes 16 --frames 5 --seed 7 -o cabins\n"
      "The folder: docs/formats/cockpit.md");
  verb->callback([flags, verb] {
    refuse_flags_of_other_sensor(*verb, flags->sensor);
    run(*flags);
  });
}

}  // namespace raybundle::apps
