// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Writes one problem of the benchmark, with its truth, for all peers alike.
// usage: generate_problem FOLDER [--family NAME] [--frames N] [--noise-px X] [--outliers SHARE] [--bend-m X]
//        [--seed N] [--noise-seed N]
#include <CLI/CLI.hpp>
#include <cstdio>

#include "problem.hpp"
#include "raybundle/geometry/error.hpp"

int main(int argc, char** argv) {
  using namespace raybundle;
  CLI::App app("one problem of the benchmark, with its truth");
  bench::ProblemSpec spec;
  std::string folder;
  app.add_option("folder", folder, "where to write it")->required();
  app.add_option("--family", spec.family)->capture_default_str();
  app.add_option("--frames", spec.frames)->capture_default_str();
  app.add_option("--noise-px", spec.noise_px)->capture_default_str();
  app.add_option("--outliers", spec.outlier_fraction, "share of the corners")->capture_default_str();
  app.add_option("--bend-m", spec.bend_m, "of the board")->capture_default_str();
  app.add_option("--seed", spec.seed, "of the poses")->capture_default_str();
  app.add_option("--noise-seed", spec.noise_seed)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    bench::write_problem(folder, bench::make_problem(spec));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "generate_problem: %s\n", error.what());
    return 2;
  }
  return 0;
}
