// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Does calibrate() use all of the information that the corners hold? The same boards with many draws of the noise: the
// root of the mean squared true error of the projection over the covered image, over the Cramér-Rao bound of the same
// quantity. Fails when a ratio lies above its bar by more than two of its standard errors.
// usage: prove_true_error [draws] [views] [words that the names of the problems must hold]
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "problem.hpp"
#include "raybundle/calibrate/calibrate.hpp"
#include "true_error_bound.hpp"

namespace {

using namespace raybundle;

constexpr double kBar = 1.05;

struct Case {
  const char* family;
  bool shape;
  double outliers;
};

bool prove(const Case& which, int draws, int views) {
  bench::ProblemSpec spec;
  spec.family = which.family;
  spec.frames = views;
  spec.outlier_fraction = which.outliers;
  if (which.shape) spec.bend_m = 0.001;
  const bench::PeerProblem exact = bench::exact_problem(spec);
  const double bound_px = bench::true_error_bound(bench::with_noise(exact, spec), 0, which.shape).rms_px;
  double sum = 0, sum_squared = 0;
  for (int draw = 0; draw < draws; ++draw) {
    spec.noise_seed = static_cast<unsigned>(draw + 1);
    const bench::PeerProblem made = bench::with_noise(exact, spec);
    const CalibrationResult result = calibrate(made.problem, {.estimate_shape = which.shape, .threads = 1});
    const double off = bench::true_error(made.grid[0], result.calibration.cameras[0].camera).rms_px / bound_px;
    sum += off * off;
    sum_squared += std::pow(off, 4);
  }
  const double mean = sum / draws;
  const double mean_error = std::sqrt((sum_squared / draws - mean * mean) / draws);
  const double ratio = std::sqrt(mean), ratio_error = mean_error / (2 * ratio);
  const bool passed = ratio - 2 * ratio_error <= kBar;
  std::printf("%-18s %s %3.0f %% outliers  %d views  bound %.4f px  true error / bound %.3f +- %.3f  bar %.2f  %s\n",
              which.family, which.shape ? "bent board," : "flat board,", 100 * which.outliers, views, bound_px, ratio,
              ratio_error, kBar, passed ? "passed" : "FAILED");
  std::fflush(stdout);
  return passed;
}

}  // namespace

int main(int argc, char** argv) {
  const int draws = argc > 1 ? std::atoi(argv[1]) : 200;
  const int views = argc > 2 ? std::atoi(argv[2]) : 30;
  const std::string wanted = argc > 3 ? argv[3] : "";
  bool passed = true;
  for (const Case& which :
       {Case{"kb130", false, 0}, Case{"kb130", true, 0}, Case{"kb130", false, 0.01}, Case{"kb150", false, 0},
        Case{"rational70", false, 0}, Case{"rational70", true, 0}, Case{"stereo_kb130", false, 0}}) {
    if (std::string(which.family).find(wanted) == std::string::npos) continue;
    passed = prove(which, draws, views) && passed;
  }
  return passed ? 0 : 1;
}
