// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "raybundle/camera/camera.hpp"
#include "raybundle/geometry/rigid3.hpp"
#include "raybundle/scene/observation.hpp"
#include "raybundle/scene/survey.hpp"
#include "raybundle/scene/target.hpp"

namespace raybundle {

/// A camera to be calibrated. What is known of it beforehand is optional: no focal length is ever needed.
struct ProblemCamera {
  std::string name;
  ModelId model;
  ImageSize size;
  std::optional<Eigen::VectorXd> parameters;  ///< start of the intrinsics, as Camera::parameters
  std::optional<Rigid3> camera_from_rig;      ///< start of the extrinsics
};

/// What the solve may do with parameters. `pattern` is `camera.parameter` with * and ? as wildcards:
/// left.fx, *.k3, left.intrinsics (all of them), right.camera_from_rig, right.camera_from_rig.translation_x,
/// board.shape. Later rules override earlier ones.
struct ParameterRule {
  enum class Kind { kFree, kFixed, kPrior };
  std::string pattern;
  Kind kind = Kind::kFree;
  std::optional<double> value;  ///< fixed at, or prior mean; without it the start value
  double sigma = 0.0;           ///< of the prior, > 0, in the parameter's unit
};

/// One dot whose beam is known: it fixes the origin of labels that are otherwise known only up to a shift of the grid.
struct LaserAnchor {
  int view = 0;                                     ///< index into CalibrationProblem::views
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< the dot nearest to it is meant [px]
  int beam = 0;
};

/// A dot projector, fixed to the rig. What fixes the origin of the labels is optional; without any of it they count
/// from the outermost beams that were seen.
struct ProblemLaser {
  LaserGrid grid;
  std::optional<LaserAnchor> anchor = {};
  std::optional<int> brightest = {};  ///< the beam that outshines the others, usually order zero
  std::vector<int> missing = {};      ///< beams that the projector does not make
};

/// Everything that is known before the solve: views of boards by cameras, in frames (moments in time).
struct CalibrationProblem {
  std::vector<ProblemCamera> cameras;  ///< the first one's frame is the rig frame
  std::vector<Target> targets;         ///< several boards move independently of each other
  std::vector<std::string> frames;     ///< names of the moments
  std::vector<TargetView> views;       ///< at most one for each camera, frame and target
  std::vector<ParameterRule> rules;
  std::vector<ParameterRule> lens_priors = {};  ///< filled by calibrate(); any rule overrides them
  std::optional<ProblemLaser> laser;            ///< without it no view has dots
  std::optional<Survey> survey = {};            ///< landmarks that take part, in images of their own
};

/// Throws Error(kBadInput) naming the first view, camera or rule that breaks an invariant stated in these types:
/// indices, unknown or repeated point ids, NaN, pixels far outside of the image, wrong parameter counts, sigma <= 0.
void check(const CalibrationProblem& problem);

/// Gives the observations of a board the labels that one of its symmetries takes theirs to.
///
/// @param symmetry  of target.symmetries; -1: as labelled
void relabel(const Target& target, int symmetry, std::vector<Observation>& observations);

/// `camera left, frame 8`: how messages name a view.
std::string view_name(const CalibrationProblem& problem, const TargetView& view);

}  // namespace raybundle
