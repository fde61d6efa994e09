// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "raybundle/bundle/bundle.hpp"

namespace raybundle::bench {

/// What a problem of the benchmark is made of. Boards of 14 × 10 corners, each seen whole.
struct ProblemSpec {
  std::string family = "kb130";  ///< one of problem_families()
  int frames = 200;
  double noise_px = 0.3;
  double outlier_fraction = 0.0;  ///< of the corners, moved by 5 to 50 px
  double bend_m = 0.0;            ///< bend_x of the board; half of it the other way in bend_y
  unsigned seed = 1;              ///< of the poses
  unsigned noise_seed = 1;        ///< of noise and outliers
};

/// A pixel of the covered image and the true ray that lands on it.
struct GridPoint {
  Eigen::Vector3d ray_in_camera;
  Eigen::Vector2d pixel;
};

/// A problem whose answer is known, in the form that all peers are given.
struct PeerProblem {
  std::string family;
  int columns = 0;
  int rows = 0;
  double square_m = 0.0;
  CalibrationProblem problem;
  BundleState truth;                         ///< outliers are marked
  std::vector<std::vector<GridPoint>> grid;  ///< aligned with problem.cameras
};

/// kb130, kb150, rational70, stereo_kb130, stereo_rational70, rig4_kb130: lens and field of view in degrees across the
/// image; a stereo pair; four cameras in an arc.
std::vector<std::string> problem_families();

/// The problem of a specification; the same specification gives the same bits.
///
/// @throws Error(kBadInput) for an unknown family
PeerProblem make_problem(const ProblemSpec& spec);

/// The problem without noise, and the noise and outliers of a specification on top of it: what make_problem does.
PeerProblem exact_problem(const ProblemSpec& spec);
PeerProblem with_noise(PeerProblem exact, const ProblemSpec& spec);

/// Writes problem.json (sizes, truth, what the peers need to know), pixels.f64 (camera × frame × corner × (u, v), NaN
/// where the camera did not see the board), poses.f64 and start.f64 (frame × rotation xyzw, translation), grid.f64
/// (point × ray, pixel; camera by camera) and observations.json into a folder.
void write_problem(const std::filesystem::path& folder, const PeerProblem& problem);

/// The observations and the grid of a folder that write_problem wrote; no truth.
PeerProblem read_problem(const std::filesystem::path& folder);

}  // namespace raybundle::bench
