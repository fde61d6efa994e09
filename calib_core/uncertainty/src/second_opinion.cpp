// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/second_opinion.hpp"

#include <algorithm>

#include "mrcal_request.hpp"
#include "raybundle/bundle/bundle.hpp"
#include "splined_opinion.hpp"

namespace raybundle {
namespace {

std::optional<std::string> mrcal_name(ModelId model) {
  for (const ForeignName& foreign : foreign_names(model)) {
    if (foreign.format == "mrcal") return std::string(foreign.name);
  }
  return std::nullopt;
}

// The first opinion's solve once more, of the corners alone, with all coefficients free and boards that bend but do not
// twist; nothing when it does not come to rest.
std::optional<Calibration> as_mrcal_solves(const CalibrationProblem& problem, const CalibrationResult& first) {
  CalibrationProblem held = problem;
  held.laser.reset();
  held.rules.clear();
  for (const Target& target : problem.targets) {
    held.rules.push_back({target.name + ".twist", ParameterRule::Kind::kFixed, 0.0});
  }
  BundleState state;
  for (const RigCamera& camera : first.calibration.cameras) {
    state.cameras.push_back(camera.camera);
    state.camera_from_rig.push_back(camera.camera_from_rig);
  }
  for (const CalibratedTarget& target : first.calibration.targets) state.shapes.push_back(target.shape);
  state.poses = first.poses;
  for (std::size_t v = 0; v < held.views.size(); ++v) {
    state.pose_of_view.push_back(first.views[v].pose);
    state.fates.push_back(first.views[v].fates);
    TargetView& view = held.views[v];
    relabel(held.targets[view.target], first.views[v].symmetry, view.observations);
  }
  const BundleSummary summary =
      solve_bundle(held, state, {.estimate_shape = is_bent(first.calibration.targets[first.poses[0].target].shape)});
  if (summary.termination != Termination::kConverged) return std::nullopt;
  Calibration calibration = first.calibration;
  calibration.laser.reset();
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    calibration.cameras[c].camera = state.cameras[c];
    calibration.cameras[c].camera_from_rig = state.camera_from_rig[c];
  }
  return calibration;
}

// What mrcal's answer is held against: the first opinion, or its like by what mrcal knows.
struct Counterpart {
  std::optional<Calibration> calibration;
  std::string remark;
};

// Whether calibrate() has given up coefficients of a lens; no rule did, for then there is no opinion.
bool holds_coefficients(const Calibration& first) {
  return std::ranges::any_of(first.cameras, [](const RigCamera& camera) {
    const auto shape = camera.camera.parameters.tail(camera.camera.parameters.size() - 4);
    return shape.size() > 0 && (shape.array() == 0.0).any();
  });
}

Counterpart counterpart_of(const CalibrationProblem& problem, const CalibrationResult& first) {
  const bool twisted = first.calibration.targets[first.poses[0].target].shape.twist_m != 0.0;
  std::string without;
  for (const auto& [there, what] :
       {std::pair{twisted, "the board's twist"}, std::pair{!first.lens_priors.empty(), "the prior of the lens"},
        std::pair{holds_coefficients(first.calibration), "coefficients held at zero"},
        std::pair{first.laser.has_value(), "dots"}, std::pair{first.survey.has_value(), "landmarks"}}) {
    if (there) without += (without.empty() ? "" : " and ") + std::string(what);
  }
  if (without.empty()) return {first.calibration, {}};
  return {as_mrcal_solves(problem, first),
          "held against our solve of the corners without " + without + ", which mrcal does not get"};
}

// Some percent away: mrcal has to find the optimum itself, and nothing is degenerate as without distortion.
Eigen::VectorXd disturbed(Eigen::VectorXd parameters) {
  parameters.head<2>() *= 1.02;
  parameters.tail(parameters.size() - 4) *= 0.9;
  return parameters;
}

// Why mrcal has no model like the cameras'; empty when it has.
std::string objection_to_model(const Calibration& first) {
  for (const RigCamera& camera : first.cameras) {
    if (!mrcal_name(camera.camera.model)) {
      return "mrcal has no model like " + std::string(model_name(camera.camera.model));
    }
    if (camera.camera.model != first.cameras[0].camera.model) return "mrcal gives all cameras of a rig the same model";
  }
  return {};
}

SecondOpinion parametric_opinion(MrcalProblem request, const CalibrationProblem& problem,
                                 const CalibrationResult& result) {
  SecondOpinion opinion;
  opinion.why_not = objection_to_model(result.calibration);
  if (!opinion.why_not.empty()) return opinion;
  const Counterpart counterpart = counterpart_of(problem, result);
  if (!counterpart.calibration) {
    opinion.why_not = counterpart.remark + "; but that solve does not come to rest";
    return opinion;
  }
  const Calibration& first = *counterpart.calibration;
  request.lens_model = *mrcal_name(first.cameras[0].camera.model);
  opinion.source = "mrcal, " + request.lens_model;
  for (std::size_t c = 0; c < first.cameras.size(); ++c) {
    request.cameras[c].parameters = disturbed(first.cameras[c].camera.parameters);
  }
  std::optional<MrcalAnswer> answer = solve_with_mrcal(request);
  for (std::size_t c = 0; c < first.cameras.size(); ++c) {
    request.cameras[c].parameters = first.cameras[c].camera.parameters;
  }
  const std::optional<MrcalAnswer> from_first = solve_with_mrcal(request);
  if (!answer || (from_first && from_first->rms_px < 0.999 * answer->rms_px)) {
    answer = from_first;
    opinion.source += " (from the first opinion's lenses)";
  }
  if (!answer) {
    opinion.why_not = "mrcal's optimiser did not find a solution";
    return opinion;
  }
  opinion.rms_px = answer->rms_px;
  Calibration second = first;
  for (std::size_t c = 0; c < answer->cameras.size(); ++c) {
    second.cameras[c].camera.parameters = answer->cameras[c].parameters;
    second.cameras[c].camera_from_rig = answer->cameras[c].camera_from_rig;
  }
  opinion.comparison = compare(first, second);
  opinion.remark = counterpart.remark;
  return opinion;
}

// With the weights that the first opinion gave its cameras.
CalibrationProblem weighed_as(CalibrationProblem problem, const CalibrationResult& first) {
  for (TargetView& view : problem.views) {
    for (Observation& seen : view.observations) seen.sigma_px *= first.cameras[view.camera].sigma_scale;
  }
  return problem;
}

}  // namespace

bool second_opinion_available() { return mrcal_available(); }

std::vector<SecondOpinion> second_opinions(const CalibrationProblem& given, const CalibrationResult& first) {
  SecondOpinion none;
  none.why_not = mrcal_objection(given, first);
  if (!none.why_not.empty()) return {none};
  const CalibrationProblem problem = weighed_as(given, first);
  const MrcalProblem request = mrcal_request(problem, first);
  return {parametric_opinion(request, problem, first), splined_opinion(request, first.calibration)};
}

}  // namespace raybundle
