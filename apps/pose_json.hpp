// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include "raybundle/geometry/rigid3.hpp"

namespace raybundle::apps {

/// A transform as all our files hold it: `rotation_xyzw`, `translation_m`.
inline nlohmann::ordered_json json_from_pose(const Rigid3& b_from_a) {
  const Eigen::Vector4d q = b_from_a.rotation.coeffs();
  const Eigen::Vector3d& t = b_from_a.translation;
  return {{"rotation_xyzw", {q[0], q[1], q[2], q[3]}}, {"translation_m", {t[0], t[1], t[2]}}};
}

/// The same read back. @throws nlohmann::json::exception when it is not all there
inline Rigid3 pose_from_json(const nlohmann::json& json) {
  const nlohmann::json &q = json.at("rotation_xyzw"), &t = json.at("translation_m");
  return {
      Eigen::Quaterniond(q.at(3).get<double>(), q.at(0).get<double>(), q.at(1).get<double>(), q.at(2).get<double>()),
      Eigen::Vector3d(t.at(0).get<double>(), t.at(1).get<double>(), t.at(2).get<double>())};
}

}  // namespace raybundle::apps
