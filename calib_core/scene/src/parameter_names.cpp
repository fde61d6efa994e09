// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/scene/parameter_names.hpp"

#include <array>
#include <string_view>

#include "raybundle/geometry/rotation.hpp"

namespace raybundle {
namespace {

template <typename Names>
std::vector<std::string> prefixed(const std::string& prefix, const Names& names) {
  std::vector<std::string> all;
  for (const std::string_view name : names) all.push_back(prefix + std::string(name));
  return all;
}

}  // namespace

std::vector<std::string> intrinsic_names(const std::string& camera, ModelId model) {
  return prefixed(camera + ".", parameter_names(model));
}

std::vector<std::string> intrinsic_names(const RigCamera& camera) {
  return intrinsic_names(camera.name, camera.camera.model);
}

std::vector<std::string> extrinsic_names(const std::string& camera) {
  constexpr std::array kMotion{"rotation_x",    "rotation_y",    "rotation_z",
                               "translation_x", "translation_y", "translation_z"};
  return prefixed(camera + ".camera_from_rig.", kMotion);
}

std::vector<std::string> extrinsic_names(const RigCamera& camera) { return extrinsic_names(camera.name); }

std::vector<std::string> shape_names(const std::string& target) {
  return prefixed(target + ".", std::array{"bend_x", "bend_y", "twist"});
}

std::map<std::string, double> parameter_values(const Calibration& calibration) {
  std::map<std::string, double> values;
  const auto add = [&](const std::vector<std::string>& names, const Eigen::VectorXd& of_names) {
    for (std::size_t i = 0; i < names.size(); ++i) values[names[i]] = of_names[static_cast<Eigen::Index>(i)];
  };
  for (const RigCamera& camera : calibration.cameras) {
    add(intrinsic_names(camera), camera.camera.parameters);
    Eigen::Matrix<double, 6, 1> place;
    place << vector_from_rotation(camera.camera_from_rig.rotation.toRotationMatrix()),
        camera.camera_from_rig.translation;
    add(extrinsic_names(camera), place);
  }
  for (const CalibratedTarget& board : calibration.targets) add(shape_names(board.target.name), board.shape.sags());
  return values;
}

}  // namespace raybundle
