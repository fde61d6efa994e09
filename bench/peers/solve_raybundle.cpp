// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Times calibrate() on one problem of the benchmark, from observations in memory, and says how far from the truth it
// is. usage: solve_raybundle FOLDER RESULT.json [--plain] [--threads N] [--estimate-shape BOOL] [--robust-scale-sigma
// X]
// --plain: start values and least squares instead, and nothing else.
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "plain_solve.hpp"
#include "problem.hpp"
#include "raybundle/calibrate/calibrate.hpp"
#include "true_error_bound.hpp"

namespace {

using namespace raybundle;
using nlohmann::json;

double cpu_seconds() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

double peak_mb() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

json cameras_json(const bench::PeerProblem& made, const std::vector<Camera>& found, const std::vector<Rigid3>& places) {
  json cameras = json::array();
  for (std::size_t c = 0; c < found.size(); ++c) {
    const bench::TrueError error = bench::true_error(made.grid[c], found[c]);
    const Eigen::Vector4d removed = error.estimated_from_true.coeffs();
    const Eigen::Vector4d rotation = places[c].rotation.coeffs();
    const Eigen::Vector3d translation = places[c].translation;
    cameras.push_back({{"true_error_rms_px", error.rms_px},
                       {"true_error_max_px", error.max_px},
                       {"unprojectable", error.unprojectable},
                       {"removed_rotation_xyzw", std::vector<double>(removed.begin(), removed.end())},
                       {"rotation_xyzw", std::vector<double>(rotation.begin(), rotation.end())},
                       {"translation_m", std::vector<double>(translation.begin(), translation.end())}});
  }
  return cameras;
}

// calibrate() or plain_solve(), into the cameras and what else there is to tell.
void solve(CalibrationProblem& problem, const CalibrateOptions& options, bool plain, std::vector<Camera>& cameras,
           std::vector<Rigid3>& places, json& told) {
  if (plain) {
    const BundleState state = bench::plain_solve(problem, options.threads);
    cameras = state.cameras;
    places = state.camera_from_rig;
    return;
  }
  const CalibrationResult result = calibrate(problem, options);
  for (const RigCamera& camera : result.calibration.cameras) {
    cameras.push_back(camera.camera);
    places.push_back(camera.camera_from_rig);
  }
  told["rms_px"] = result.rms_px;
  told["iterations"] = result.iterations;
  for (const StageTime& stage : result.stages) told["stages"][stage.name] = stage.seconds;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("times calibrate() on one problem of the benchmark");
  std::string folder, output;
  CalibrateOptions options;
  options.threads = 1;
  bool plain = false;
  app.add_flag("--plain", plain, "start values and least squares only");
  app.add_option("folder", folder)->required();
  app.add_option("output", output)->required();
  CalibrateOptions::for_each_option(options, [&](const char* name, const char*, const char* help, auto& value) {
    std::string flag = "--" + std::string(name);
    std::ranges::replace(flag, '_', '-');
    app.add_option(flag, value, help);
  });
  CLI11_PARSE(app, argc, argv);
  try {
    bench::PeerProblem made = bench::read_problem(folder);
    const double memory_before_mb = peak_mb(), cpu_before = cpu_seconds();
    const auto before = std::chrono::steady_clock::now();
    std::vector<Camera> cameras;
    std::vector<Rigid3> places;
    json out;
    solve(made.problem, options, plain, cameras, places, out);
    const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
    out["cpu_s"] = cpu_seconds() - cpu_before;
    out["wall_s"] = wall;
    out["peak_mb"] = peak_mb();
    out["before_mb"] = memory_before_mb;
    out["cameras"] = cameras_json(made, cameras, places);
    std::ofstream stream(output);
    stream << out.dump(1) << '\n';
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 4;
  }
  return 0;
}
