// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <string>

#include "raybundle/scene/problem.hpp"

namespace raybundle::testing {

/// The plain table camera,frame,point_id,u,v of a problem's views.
inline std::string csv_of(const CalibrationProblem& problem) {
  std::string csv = "camera,frame,point_id,u,v\n";
  for (const TargetView& view : problem.views) {
    for (const Observation& corner : view.observations) {
      csv += fmt::format("{},{},{},{:.10f},{:.10f}\n", problem.cameras[view.camera].name, problem.frames[view.frame],
                         corner.point_id, corner.pixel.x(), corner.pixel.y());
    }
  }
  return csv;
}

}  // namespace raybundle::testing
