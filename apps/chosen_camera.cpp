// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "chosen_camera.hpp"

#include <fmt/format.h>

#include "raybundle/geometry/error.hpp"

namespace raybundle::apps {

const RigCamera& chosen_camera(const Calibration& calibration, const std::string& name) {
  if (!name.empty()) return camera_named(calibration, name);
  if (calibration.cameras.size() == 1) return calibration.cameras.front();
  throw Error(ErrorKind::kBadInput, fmt::format("which camera? Give --camera, as in --camera {}; there are {} cameras",
                                                calibration.cameras.front().name, calibration.cameras.size()));
}

}  // namespace raybundle::apps
