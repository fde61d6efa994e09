// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// The same as prove_laser from images: each seed is simulated, calibrated and validated on other poses by the program,
// as a person would. Bars are those of observations times 1.5. Each line: median (worst) over the seeds. usage:
// prove_laser_images [seeds, default 20] [views, default 60] [beams, default 11x11]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include <unistd.h>

#include "laser_figures.hpp"
#include "raybundle/io/calibration_file.hpp"

namespace {

using namespace raybundle;
using namespace raybundle::bench;
namespace fs = std::filesystem;

bool run(const std::string& arguments) {
  return std::system((RAYBUNDLE_PROGRAM " " + arguments + " >/dev/null 2>&1").c_str()) == 0;
}

struct Figures {
  double depth_bias_mm = INFINITY;
  double plane_half_mm = INFINITY;  // in validate's band about 0.5 m
  double plane_one_mm = INFINITY;   // and about 1 m
  int lost_beams = 0;               // farther than half a step of the grid from the truth: a wrong label
  bool calibrated = false;
};

// Beams whose label is wrong lie nearer to another beam of the truth than to their own.
int mislabelled(const LaserPattern& truth, const LaserPattern& found) {
  int count = 0;
  for (const LaserBeam& ours : found.beams) {
    double own = INFINITY, nearest = INFINITY;
    for (const LaserBeam& beam : truth.beams) {
      const double distance = distance_between(beam.line, ours.line.at(1.0));
      nearest = std::min(nearest, distance);
      if (beam.row == ours.row && beam.column == ours.column) own = distance;
    }
    count += own > nearest;
  }
  return count;
}

// Clicks on dots of beams near the grid's middle, for grids in which nothing marks a beam; the surest first. A dot may
// lie on a printed edge, where it is not found: then a person clicks on another.
std::vector<std::string> clicks(const fs::path& simulated) {
  const nlohmann::json exact = nlohmann::json::parse(std::ifstream(simulated / "truth/observations.json"));
  if (exact["laser"].contains("brightest") || exact["laser"].contains("missing")) return {""};
  std::vector<std::pair<double, std::string>> found;
  for (const nlohmann::json& view : exact["views"]) {
    for (const nlohmann::json& dot : view["dots"]) {  // u, v, covariance (3), row, column
      const double row = dot[5], column = dot[6];
      const double from_middle = std::hypot(row - exact["laser"]["rows"].get<double>() / 2,
                                            column - exact["laser"]["columns"].get<double>() / 2);
      found.emplace_back(from_middle, " --anchor camera/" + view["frame"].get<std::string>() + ":" +
                                          std::to_string(dot[0].get<double>() + 0.5) + "," +
                                          std::to_string(dot[1].get<double>() - 0.5) + "=" +
                                          std::to_string(static_cast<int>(row)) + "," +
                                          std::to_string(static_cast<int>(column)));
    }
  }
  std::ranges::sort(found);
  std::vector<std::string> best;
  for (std::size_t i = 0; i < std::min<std::size_t>(8, found.size()); ++i) best.push_back(found[i].second);
  return best;
}

Figures figures_of(const fs::path& folder, int seed, int views, const std::string& beams) {
  Figures figures;
  const std::string rig = RAYBUNDLE_SOURCE_DIR "/datasets/rigs/rig_26mm_laser.toml";
  const auto simulate = [&](const char* name, int frames, int of_seed) {
    return run("simulate " + rig + " --beams " + beams + " --frames " + std::to_string(frames) + " --seed " +
               std::to_string(of_seed) + " -o " + (folder / name).string());
  };
  if (!simulate("sim", views, seed) || !simulate("other", 20, seed + 1000000)) return figures;
  const std::string out = (folder / "out").string();
  const std::string calibrate = "calibrate " + (folder / "sim/dataset.toml").string() + " --no-cache -o " + out;
  const std::vector<std::string> anchors = clicks(folder / "sim");
  if (std::ranges::none_of(anchors, [&](const std::string& anchor) { return run(calibrate + anchor); })) return figures;
  const Calibration truth = read_calibration((folder / "sim/truth/calibration.json").string()).calibration;
  const Calibration found = read_calibration(out + "/calibration.json").calibration;
  if (!found.laser) return figures;
  figures.calibrated = true;
  figures.depth_bias_mm = depth_bias_mm(truth, found);
  figures.lost_beams = mislabelled(*truth.laser, *found.laser);
  const std::string verdict = (folder / "verdict.json").string();
  static_cast<void>(std::system((RAYBUNDLE_PROGRAM " validate " + out + "/calibration.json " +
                                 (folder / "other/dataset.toml").string() + " --json >" + verdict + " 2>/dev/null")
                                    .c_str()));
  const nlohmann::json json = nlohmann::json::parse(std::ifstream(verdict), nullptr, false);
  if (json.is_discarded() || !json.contains("laser")) return figures;
  const nlohmann::json& bands = json["laser"]["bands"];
  if (bands[1]["plane_rms_mm"].is_number()) figures.plane_half_mm = bands[1]["plane_rms_mm"];
  if (bands[2]["plane_rms_mm"].is_number()) figures.plane_one_mm = bands[2]["plane_rms_mm"];
  return figures;
}

bool line(const char* what, const std::vector<Figures>& all, double Figures::*figure, double bar) {
  std::vector<double> values;
  for (const Figures& figures : all) values.push_back(figures.*figure);
  const double worst = *std::ranges::max_element(values), middle = median(values);
  std::printf("  %-34s %6.2f (%.2f) mm, bar %.1f  %s\n", what, middle, worst, bar, middle <= bar ? "pass" : "FAIL");
  return middle <= bar;
}

}  // namespace

int main(int argc, char** argv) {
  const int seeds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 20;
  const int views = argc > 2 ? std::max(1, std::atoi(argv[2])) : 60;
  const std::string beams = argc > 3 ? argv[3] : "11x11";
  const fs::path folder = fs::temp_directory_path() / ("prove_laser_images_" + std::to_string(getpid()));
  std::vector<Figures> all;
  int lost = 0, calibrated = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    all.push_back(figures_of(folder, seed, views, beams));
    lost += all.back().lost_beams;
    calibrated += all.back().calibrated;
    fs::remove_all(folder);
  }
  std::printf("images, %s, %d views, %d seeds\n", beams.c_str(), views, seeds);
  bool passed = line("depth bias at 1 m", all, &Figures::depth_bias_mm, views >= 60 ? 3.0 : 6.0);
  passed &= line("held-out planes, 0.4 m to 0.75 m", all, &Figures::plane_half_mm, 3.0);
  passed &= line("held-out planes, 0.75 m to 1.25 m", all, &Figures::plane_one_mm, 9.0);
  std::printf("  beams with a wrong label            %d, bar 0  %s\n", lost, lost == 0 ? "pass" : "FAIL");
  std::printf("  calibrated                          %d of %d  %s\n", calibrated, seeds,
              calibrated == seeds ? "pass" : "FAIL");
  return passed && lost == 0 && calibrated == seeds ? EXIT_SUCCESS : EXIT_FAILURE;
}
