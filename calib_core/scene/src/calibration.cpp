// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/scene/calibration.hpp"

#include <algorithm>
#include <cmath>

#include "raybundle/geometry/error.hpp"

namespace raybundle {

double Covariance::sigma(const std::string& name) const {
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) return 0.0;
  const Eigen::Index i = found - names.begin();
  return std::sqrt(matrix(i, i));
}

const RigCamera& camera_named(const Calibration& calibration, const std::string& name) {
  const auto found = std::ranges::find(calibration.cameras, name, &RigCamera::name);
  if (found != calibration.cameras.end()) return *found;
  std::string known;
  for (const RigCamera& camera : calibration.cameras) known += (known.empty() ? "" : ", ") + camera.name;
  throw Error(ErrorKind::kBadInput, "no camera is called '" + name + "'; there are: " + known);
}

}  // namespace raybundle
