// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "program.hpp"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;

std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

}  // namespace

fs::path cache_of_this_build() {
  const auto built = fs::last_write_time(RAYBUNDLE_PROGRAM).time_since_epoch().count();
  const fs::path all = fs::path(RAYBUNDLE_BINARY_DIR) / "end_to_end_cache";
  const fs::path mine = all / std::to_string(built);
  std::error_code ignored;
  fs::create_directories(mine, ignored);
  for (const auto& entry : fs::directory_iterator(all, ignored)) {
    if (entry.path() != mine) fs::remove_all(entry.path(), ignored);
  }
  return mine;
}

ProgramRun raybundle_program(const std::vector<std::string>& arguments, const std::string& input,
                             const fs::path& cache) {
  static int count = 0;
  const fs::path base = fs::temp_directory_path() / fmt::format("raybundle_run_{}_{}", getpid(), count++);
  const std::string in = base.string() + ".in", out = base.string() + ".out", err = base.string() + ".err";
  write_text(in, input);
  std::string command = "XDG_CACHE_HOME=" + quoted(cache.string()) + " " + quoted(RAYBUNDLE_PROGRAM);
  for (const std::string& argument : arguments) command += " " + quoted(argument);
  command += " <" + quoted(in) + " >" + quoted(out) + " 2>" + quoted(err);
  const int status = std::system(command.c_str());
  ProgramRun run{WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(out), text_of(err)};
  for (const std::string& file : {in, out, err}) fs::remove(file);
  return run;
}

nlohmann::json json_of(const fs::path& file) { return nlohmann::json::parse(text_of(file)); }

const nlohmann::json& camera_in(const nlohmann::json& document, const std::string& name) {
  for (const auto& camera : document.at("cameras")) {
    if (camera.at("name") == name) return camera;
  }
  throw std::runtime_error("no camera " + name);
}

Rigid3 camera_from_rig(const nlohmann::json& calibration, const std::string& name) {
  const nlohmann::json& pose = camera_in(calibration, name).at("camera_from_rig");
  const auto q = pose.at("rotation_xyzw").get<std::vector<double>>();
  const auto t = pose.at("translation_m").get<std::vector<double>>();
  Rigid3 transform;
  transform.rotation = Eigen::Quaterniond(q[3], q[0], q[1], q[2]);
  transform.translation = {t[0], t[1], t[2]};
  return transform;
}

double baseline_m(const nlohmann::json& calibration, const std::string& a, const std::string& b) {
  return (camera_from_rig(calibration, b) * camera_from_rig(calibration, a).inverse()).translation.norm();
}

std::map<std::string, std::map<std::string, int>> corners_by_frame(const nlohmann::json& document) {
  std::map<std::string, std::map<std::string, int>> counts;
  for (const auto& view : document.at("views")) {
    const auto& points = view.contains("points") ? view.at("points") : view.at("observations");
    counts[view.at("camera")][view.at("frame")] += static_cast<int>(points.size());
  }
  return counts;
}

int views_with(const nlohmann::json& document, const std::string& camera, int corners) {
  int count = 0;
  const auto cameras = corners_by_frame(document);
  const auto frames = cameras.find(camera);
  if (frames == cameras.end()) return 0;
  for (const auto& [frame, found] : frames->second) count += found >= corners ? 1 : 0;
  return count;
}

std::string without_provenance(const fs::path& calibration) {
  nlohmann::json json = json_of(calibration);
  json.erase("provenance");
  return json.dump();
}

nlohmann::json calibrate(const fs::path& folder, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "calibrate");
  arguments.insert(arguments.end(), {"-o", (folder / "out").string()});
  const ProgramRun run = raybundle_program(arguments);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return run.exit_code == 0 ? json_of(folder / "out" / "report.json") : nlohmann::json::object();
}

nlohmann::json detect(const fs::path& folder, std::vector<std::string> arguments) {
  const std::string file = (folder / "observations.json").string();
  arguments.insert(arguments.begin(), "detect");
  arguments.insert(arguments.end(), {"-o", file});
  const ProgramRun run = raybundle_program(arguments);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return run.exit_code == 0 ? json_of(file) : nlohmann::json::object();
}

}  // namespace raybundle::testing
