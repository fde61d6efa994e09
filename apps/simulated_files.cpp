// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "simulated_files.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "page_text.hpp"
#include "pose_json.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "raybundle/io/observations_file.hpp"
#include "raybundle/scene/atomic_file.hpp"
#include "raybundle/targets/board_file.hpp"
#include "simulated_images.hpp"

namespace raybundle::apps {
namespace {

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    throw Error(ErrorKind::kIo, fmt::format("the output folder {} cannot be made: {}; choose another with -o",
                                            folder.string(), error.message()));
  }
}

ObservationsFile observations_file(const CalibrationProblem& problem) {
  ObservationsFile file{problem, {}};
  for (const ProblemCamera& camera : problem.cameras) file.models.emplace_back(camera.model);
  return file;
}

std::string laser_section(const ProblemLaser& laser) {
  std::string text = fmt::format("\n[laser]\ngrid = \"{}x{}\"\n", laser.grid.columns, laser.grid.rows);
  const auto label = [&](int beam) { return fmt::format("[{}, {}]", laser.grid.row(beam), laser.grid.column(beam)); };
  if (laser.brightest) text += fmt::format("brightest = {}\n", label(*laser.brightest));
  if (!laser.missing.empty()) {
    std::string list;
    for (const int beam : laser.missing) list += (list.empty() ? "" : ", ") + label(beam);
    text += fmt::format("missing = [{}]\n", list);
  }
  return text;
}

// A string of JSON is one of TOML, too.
std::string quoted(const std::string& text) { return text_of_json(nlohmann::json(text)); }

std::string poses_text(const Simulation& simulation) {
  nlohmann::ordered_json poses = nlohmann::ordered_json::array();
  for (const BoardPose& pose : simulation.poses) {
    poses.push_back({{"frame", simulation.problem.frames[pose.frame]},
                     {"target", pose.target},
                     {"rig_from_target", json_from_pose(pose.rig_from_target)}});
  }
  return text_of_json(nlohmann::ordered_json{{"poses", poses}}, 1) + "\n";
}

}  // namespace

std::string dataset_text(const BoardedRig& boarded, const ProblemLaser* laser, const std::string& command) {
  std::string text = fmt::format("# {}\n{}", command, toml_of(boarded.board));
  for (const SimulatedCamera& camera : boarded.rig.cameras) {
    text += fmt::format("\n[[camera]]\nname = {}\nimages = {}\nmodel = \"{}\"\n", quoted(camera.name),
                        quoted(simulated_image(camera.name, "*", false)), model_name(camera.camera.model));
    if (laser != nullptr) text += fmt::format("laser_on = {}\n", quoted(simulated_image(camera.name, "*", true)));
  }
  if (laser != nullptr) text += laser_section(*laser);
  return text;
}

void write_simulation(const std::filesystem::path& folder, const Simulation& simulation, const std::string& command) {
  make_folder(folder / "truth");
  CalibrationFile truth;
  truth.calibration = simulation.truth;
  truth.provenance.command = command;
  truth.provenance.versions = {{"raybundle", RAYBUNDLE_VERSION}};
  write_calibration(folder / "truth" / "calibration.json", truth);
  write_observations(folder / "truth" / "observations.json", observations_file(simulation.exact));
  write_file_whole(folder / "truth" / "poses.json", poses_text(simulation));
  write_observations(folder / "observations.json", observations_file(simulation.problem));
}

}  // namespace raybundle::apps
