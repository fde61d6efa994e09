// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "held_out.hpp"

#include <fmt/format.h>

#include <cmath>

#include "raybundle/calibrate/data_warnings.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle::apps {
namespace {

// By how much larger `a` is than `b`; nothing unless they are the same board at two scales.
std::optional<double> scale_between(const Target& a, const Target& b) {
  if (a.points.size() != b.points.size()) return std::nullopt;
  double ab = 0.0, bb = 0.0, aa = 0.0;
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    if (a.points[i].id != b.points[i].id) return std::nullopt;
    ab += a.points[i].x_in_target.dot(b.points[i].x_in_target);
    aa += a.points[i].x_in_target.squaredNorm();
    bb += b.points[i].x_in_target.squaredNorm();
  }
  const double scale = ab / bb;
  const double misfit = aa - scale * ab;  // squared distances of a from the scaled b
  if (!(std::abs(misfit) <= 1e-12 * aa)) return std::nullopt;
  return scale;
}

// The board with its points on the surface that the calibration found; its ids and symmetries stay.
Target bent(const Target& target, const BoardShape& shape) {
  Target result = target;
  const std::vector<Eigen::Vector3d> points = points_on_surface(target, shape);
  for (std::size_t i = 0; i < points.size(); ++i) result.points[i].x_in_target = points[i];
  return result;
}

// The board of the calibration that a target is, and how much larger: of several that are alike the one of its name.
std::pair<const CalibratedTarget*, double> known_board(const Calibration& calibration, const Target& target) {
  std::pair<const CalibratedTarget*, double> known{nullptr, 1.0};
  for (const CalibratedTarget& board : calibration.targets) {
    const std::optional<double> scale = scale_between(target, board.target);
    const bool named = board.target.name == target.name;
    if (scale && (known.first == nullptr || named)) known = {&board, *scale};
    if (scale && named) break;
  }
  return known;
}

void bend_known_boards(const Calibration& calibration, HeldOut& held) {
  for (Target& target : held.problem.targets) {
    const auto [known, scale] = known_board(calibration, target);
    if (known == nullptr) continue;
    if (std::abs(scale - 1.0) > 1e-6) {
      held.warnings.push_back(fmt::format(
          "{} is given {:.6g} times as large as the board of the calibration: is the unit right?", target.name, scale));
    }
    target = bent(target, BoardShape::from_sags(scale * known->shape.sags()));
  }
}

}  // namespace

HeldOut held_out(const CalibrationFile& file, const CalibrationProblem& observed) {
  HeldOut held{observed, {}};
  CalibrationProblem& problem = held.problem;
  for (const Target& target : problem.targets) {
    if (const std::string warning = unit_warning(target); !warning.empty()) held.warnings.push_back(warning);
  }
  for (ProblemCamera& camera : problem.cameras) {
    const RigCamera& known = camera_named(file.calibration, camera.name);
    const bool never_seen = camera.size == ImageSize{};  // none of its images could be read
    if (never_seen) camera.size = known.camera.size;
    if (camera.size != known.camera.size) {
      throw Error(ErrorKind::kBadInput,
                  fmt::format("camera {} has {}x{} images, but was calibrated at {}x{}", camera.name, camera.size.width,
                              camera.size.height, known.camera.size.width, known.camera.size.height));
    }
    camera.model = known.camera.model;
    camera.parameters = known.camera.parameters;
    camera.camera_from_rig = known.camera_from_rig;
  }
  // The rig frame of the observations is that of their first camera.
  const Rigid3 rig_from_first = problem.cameras.front().camera_from_rig->inverse();
  for (ProblemCamera& camera : problem.cameras) camera.camera_from_rig = *camera.camera_from_rig * rig_from_first;
  problem.laser.reset();  // beams are not held, they are tested
  for (TargetView& view : problem.views) view.dots.clear();
  problem.rules = {{"*.intrinsics", ParameterRule::Kind::kFixed, {}, 0.0}};
  if (problem.cameras.size() > 1) problem.rules.push_back({"*.camera_from_rig", ParameterRule::Kind::kFixed, {}, 0.0});
  bend_known_boards(file.calibration, held);
  return held;
}

}  // namespace raybundle::apps
