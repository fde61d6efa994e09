// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "drag.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "raybundle/bundle/parameters.hpp"

namespace raybundle {

std::vector<DraggedParameter> drag_of(const CalibrationProblem& problem, const BundleState& without,
                                      const BundleState& with, const BundleOptions& bundle, const Covariance& known) {
  std::vector<DraggedParameter> dragged;
  for (const ParameterBlock& block : estimated_blocks(problem, without, bundle)) {
    if (block.kind == ParameterBlock::Kind::kShape) continue;
    const PriorMean before = current_values(without, block), after = current_values(with, block);
    const bool pose = block.kind == ParameterBlock::Kind::kCameraFromRig;
    const Eigen::VectorXd motion = pose ? motion_between(before.camera_from_rig, after.camera_from_rig)
                                        : Eigen::Matrix<double, 6, 1>(Eigen::Matrix<double, 6, 1>::Zero());
    for (const int i : block.free()) {
      const std::string& name = block.parameters[i].name;
      const double sigma = known.sigma(name);
      dragged.push_back(pose ? DraggedParameter{name, 0.0, motion[i], sigma}
                             : DraggedParameter{name, before.values[i], after.values[i], sigma});
    }
  }
  return dragged;
}

std::optional<std::string> drag_warning(const std::vector<DraggedParameter>& parameters, const std::string& what,
                                        const std::string& mistake) {
  constexpr double kMostSigmas = 4.0;
  const auto worst = std::ranges::max_element(parameters, {}, &DraggedParameter::moved_sigmas);
  if (worst == parameters.end() || worst->moved_sigmas() <= kMostSigmas) return std::nullopt;
  return fmt::format(
      "{} drag the cameras: {} is {:.6g} with them and {:.6g} without, {:.1f} of its sigmas away; they contradict the "
      "corners, so look for {}, a bent board or a lens model that does not fit, or keep the cameras with --fix "
      "'*.intrinsics'",
      what, worst->name, worst->with, worst->without, worst->moved_sigmas(), mistake);
}

}  // namespace raybundle
