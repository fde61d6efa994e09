// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "json_camera.hpp"

#include <fmt/format.h>

#include <string>

namespace raybundle {
namespace {

// Standard deviations of what was estimated; parameters that were held fixed do not appear.
OrderedJson json_from_sigmas(const RigCamera& camera, const Covariance& covariance) {
  OrderedJson sigmas = OrderedJson::object();
  const auto add = [&](const std::string& parameter) {
    const double sigma = covariance.sigma(camera.name + "." + parameter);
    if (sigma > 0) sigmas[parameter] = sigma;
  };
  for (const std::string_view name : parameter_names(camera.camera.model)) add(std::string(name));
  for (const char* part : {"rotation_", "translation_"}) {
    for (const char* axis : {"x", "y", "z"}) add(std::string("camera_from_rig.") + part + axis);
  }
  return sigmas;
}

}  // namespace

void add_estimates(const RigCamera& camera, const Covariance& covariance, OrderedJson& entry) {
  const std::vector<std::string_view> names = parameter_names(camera.camera.model);
  for (std::size_t k = 0; k < names.size(); ++k) {
    entry["parameters"][std::string(names[k])] = camera.camera.parameters[static_cast<Eigen::Index>(k)];
  }
  entry["camera_from_rig"] = json_from_rigid3(camera.camera_from_rig);
  entry["sigmas"] = json_from_sigmas(camera, covariance);
}

OrderedJson json_from_shape_sigmas(const Covariance& covariance, const std::string& target) {
  OrderedJson sigmas = OrderedJson::object();
  for (const char* name : {"bend_x", "bend_y", "twist"}) {
    const double sigma = covariance.sigma(fmt::format("{}.{}", target, name));
    if (sigma > 0) sigmas[fmt::format("{}_m", name)] = sigma;
  }
  return sigmas;
}

}  // namespace raybundle
