// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/scene/problem.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

constexpr double kFarthestPoint_m = 1000.0;
constexpr int kMostRows = 4096;  // of a laser's grid, and columns: far above any grating, far below what overflows
constexpr double kSmallestSigma_px = 1e-6, kLargestSigma_px = 1e6;  // their squares are added up

[[noreturn]] void refuse(const std::string& message, const std::string& where = {}) {
  throw Error(ErrorKind::kBadInput, message, where);
}

bool in_range(int index, std::size_t size) { return index >= 0 && index < static_cast<int>(size); }

void check_camera(const ProblemCamera& camera, bool has_views) {
  const std::string where = "camera " + camera.name;
  if (camera.name.empty()) refuse("a camera has no name; give each camera one");
  if (!in_range(camera.model.index, Models::kSize)) refuse("unknown camera model", where);
  const bool never_seen = camera.size == ImageSize{} && !has_views;  // none of its images could be read
  if (!never_seen && (camera.size.width < 2 || camera.size.height < 2)) refuse("the image size is not set", where);
  if (!camera.parameters) return;
  const std::size_t count = parameter_names(camera.model).size();
  if (camera.parameters->size() != static_cast<Eigen::Index>(count)) {
    refuse("has " + std::to_string(camera.parameters->size()) + " start parameters, " +
               std::string(model_name(camera.model)) + " needs " + std::to_string(count),
           where);
  }
  if (!camera.parameters->allFinite()) refuse("a start parameter is not a finite number", where);
}

void refuse_points_in_one_place(const Target& target, const std::string& where) {
  std::map<std::tuple<double, double, double>, int> id_at;
  for (const TargetPoint& point : target.points) {
    const Eigen::Vector3d& x = point.x_in_target;
    const auto [other, is_new] = id_at.try_emplace({x.x(), x.y(), x.z()}, point.id);
    if (is_new) continue;
    refuse("points " + std::to_string(other->second) + " and " + std::to_string(point.id) +
               " lie in the same place; correct one",
           where);
  }
}

// Each takes the points' ids to the same ids in another order.
void check_symmetries(const Target& target, const std::string& where) {
  std::vector<int> ids;
  for (const TargetPoint& point : target.points) ids.push_back(point.id);
  for (const TargetSymmetry& symmetry : target.symmetries) {
    std::vector<int> images = symmetry.ids;
    std::ranges::sort(images);
    if (images != ids) refuse("a symmetry does not name each of the board's points once", where);
  }
}

void check_target(const Target& target) {
  const std::string where = "target " + target.name;
  if (target.points.size() < 4) refuse("a target needs at least 4 points", where);
  for (std::size_t i = 0; i < target.points.size(); ++i) {
    const TargetPoint& point = target.points[i];
    const std::string name = "point " + std::to_string(point.id);
    if (!point.x_in_target.allFinite()) refuse(name + " is not finite", where);
    if (point.x_in_target.norm() > kFarthestPoint_m) {
      refuse(name + " lies more than a kilometre from the board's origin; coordinates are in metres", where);
    }
    if (i > 0 && target.points[i - 1].id >= point.id) {
      refuse("points must be sorted by id without repetition; see " + name, where);
    }
  }
  refuse_points_in_one_place(target, where);
  check_symmetries(target, where);
}

// Width and height mixed up, in the file or in the image size: as given, corners lie outside of the image in number;
// the other way round all of them lie inside.
void refuse_swapped_axes(const CalibrationProblem& problem, int camera) {
  const ImageSize size = problem.cameras[camera].size;
  const auto outside = [&size](double x, double y) {
    return !(x > -1.0 && y > -1.0 && x < size.width && y < size.height);
  };
  std::size_t as_given = 0, swapped = 0, all = 0;
  for (const TargetView& view : problem.views) {
    if (view.camera != camera) continue;
    for (const Observation& observation : view.observations) {
      as_given += outside(observation.pixel.x(), observation.pixel.y());
      swapped += outside(observation.pixel.y(), observation.pixel.x());
      ++all;
    }
  }
  if (swapped > 0 || as_given < 4 || as_given * 100 < all) return;
  refuse(std::to_string(as_given) + " of " + std::to_string(all) + " corners lie outside of the " +
             std::to_string(size.width) + "x" + std::to_string(size.height) +
             " image, and none would if u and v were swapped; correct the order of the columns, or the image size",
         "camera " + problem.cameras[camera].name);
}

// Shares of the image size instead of pixels.
void refuse_shares(const CalibrationProblem& problem, int camera) {
  std::size_t all = 0;
  for (const TargetView& view : problem.views) {
    if (view.camera != camera) continue;
    for (const Observation& observation : view.observations) {
      if (!(observation.pixel.cwiseAbs().maxCoeff() <= 1.0)) return;
      ++all;
    }
  }
  if (all < 4) return;
  refuse("all " + std::to_string(all) +
             " corners lie within one pixel, as shares of the image size do; give u and v in pixels",
         "camera " + problem.cameras[camera].name);
}

// Corners may lie a little outside when they were extrapolated, but not by a whole image.
void check_observation(const Observation& observation, const Target& target, ImageSize size, const std::string& where) {
  const std::string point = "point " + std::to_string(observation.point_id);
  if (target.find(observation.point_id) == nullptr) {
    refuse(point + " is not on the board (it has " + std::to_string(target.points.size()) + " points)", where);
  }
  if (!observation.pixel.allFinite()) refuse(point + " has a pixel that is not a finite number", where);
  if (!(observation.sigma_px > 0)) refuse(point + " has a sigma that is not positive", where);
  if (observation.sigma_px < kSmallestSigma_px || observation.sigma_px > kLargestSigma_px) {
    refuse(point + " has a sigma that no measurement has; it is in pixels, 1 where nothing is known", where);
  }
  const double x = observation.pixel.x(), y = observation.pixel.y();
  if (x < -0.5 * size.width || x > 1.5 * size.width || y < -0.5 * size.height || y > 1.5 * size.height) {
    refuse(point + " lies far outside of the " + std::to_string(size.width) + "x" + std::to_string(size.height) +
               " image; are the image size and the order of columns right?",
           where);
  }
}

void check_dots(const TargetView& view, const std::optional<ProblemLaser>& laser, const std::string& where) {
  if (!view.dots.empty() && !laser) refuse("has laser dots, but the problem has no laser", where);
  std::set<int> beams;
  for (std::size_t i = 0; i < view.dots.size(); ++i) {
    const Dot& dot = view.dots[i];
    const std::string name = "dot " + std::to_string(i);
    const Eigen::Matrix2d& covariance = dot.covariance_px2;
    if (!dot.pixel.allFinite()) refuse(name + " has a pixel that is not a finite number", where);
    if (!(covariance(0, 0) > 0 && covariance.determinant() > 0 && covariance == covariance.transpose())) {
      refuse(name + " has a covariance that is not symmetric and positive definite", where);
    }
    if (!(dot.brightness >= 0 && std::isfinite(dot.brightness))) {
      refuse(name + " has a brightness that is not a number from 0 up; write 0 where it is not known", where);
    }
    if (dot.beam == kUnlabelled) continue;
    if (!in_range(dot.beam, laser->grid.size())) {
      refuse(name + " has a label outside of the " + std::to_string(laser->grid.rows) + "x" +
                 std::to_string(laser->grid.columns) + " beams",
             where);
    }
    if (!beams.insert(dot.beam).second) {
      refuse("two dots are labelled row " + std::to_string(laser->grid.row(dot.beam)) + ", column " +
                 std::to_string(laser->grid.column(dot.beam)) + "; a beam makes one dot on a board",
             where);
    }
  }
}

// Landmarks by name, sightings of them by cameras that there are; the files' readers name lines, this names things.
void check_landmarks(const CalibrationProblem& problem) {
  const Survey& survey = *problem.survey;
  if (!(survey.sighting_sigma_px > 0)) refuse("the sigma of a sighting is not positive", "survey");
  std::set<std::string> names;
  for (const Landmark& landmark : survey.landmarks) {
    const std::string where = "landmark " + landmark.name;
    if (!names.insert(landmark.name).second) refuse("stands twice", where);
    if (!landmark.x_in_local.allFinite() || !(landmark.sigma >= 0)) refuse("has no finite place or sigma", where);
  }
  std::set<std::tuple<std::string, std::string, std::string>> seen;
  for (const Sighting& sighting : survey.sightings) {
    const std::string where = "sighting of " + sighting.landmark + " in " + sighting.image;
    if (!names.contains(sighting.landmark)) refuse("the landmark is not among the surveyed ones", where);
    if (!sighting.pixel.allFinite()) refuse("has a pixel that is not a finite number", where);
    if (sighting.camera.empty() && problem.cameras.size() > 1) {
      refuse("with several cameras each sighting must name its camera; add a column 'camera'", where);
    }
    const std::string& camera = sighting.camera.empty() ? problem.cameras.front().name : sighting.camera;
    if (std::ranges::find(problem.cameras, camera, &ProblemCamera::name) == problem.cameras.end()) {
      refuse("there is no camera '" + camera + "'", where);
    }
    if (!seen.emplace(sighting.image, sighting.landmark, camera).second) refuse("stands twice", where);
  }
}

void check_laser(const CalibrationProblem& problem) {
  const ProblemLaser& laser = *problem.laser;
  if (laser.grid.rows < 1 || laser.grid.columns < 1) refuse("the laser's rows and columns must be at least 1", "laser");
  if (laser.grid.rows > kMostRows || laser.grid.columns > kMostRows) {
    refuse("the laser has more than " + std::to_string(kMostRows) + " rows or columns", "laser");
  }
  const auto exists = [&](int beam) { return in_range(beam, laser.grid.size()); };
  if (laser.brightest && !exists(*laser.brightest)) refuse("the brightest beam does not exist", "laser");
  if (!std::ranges::all_of(laser.missing, exists)) refuse("a beam that is said to be missing does not exist", "laser");
  if (!laser.anchor) return;
  if (!in_range(laser.anchor->view, problem.views.size()) || !exists(laser.anchor->beam)) {
    refuse("the anchor names a view or a beam that does not exist", "laser");
  }
}

// Their shapes are parameters, which are called by the board's name.
void refuse_boards_of_one_name(const CalibrationProblem& problem) {
  std::set<std::string> names;
  for (const Target& target : problem.targets) {
    if (!names.insert(target.name).second) refuse("two boards are called '" + target.name + "'; rename one");
  }
}

void refuse_repeated_points(const TargetView& view, const std::string& where) {
  std::vector<int> ids;
  ids.reserve(view.observations.size());
  for (const Observation& observation : view.observations) ids.push_back(observation.point_id);
  std::ranges::sort(ids);
  const auto repeated = std::ranges::adjacent_find(ids);
  if (repeated != ids.end()) refuse("point " + std::to_string(*repeated) + " is observed twice", where);
}

}  // namespace

void relabel(const Target& target, int symmetry, std::vector<Observation>& observations) {
  if (symmetry < 0) return;
  const std::vector<int>& ids = target.symmetries[symmetry].ids;
  for (Observation& observation : observations) {
    observation.point_id = ids[target.find(observation.point_id) - target.points.data()];
  }
}

std::string view_name(const CalibrationProblem& problem, const TargetView& view) {
  std::string name = "camera " + problem.cameras[view.camera].name + ", frame " + problem.frames[view.frame];
  if (problem.targets.size() > 1) name += ", board " + problem.targets[view.target].name;
  return name;
}

void check(const CalibrationProblem& problem) {
  if (problem.cameras.empty()) refuse("the problem has no camera");
  if (problem.targets.empty()) refuse("the problem has no target");
  if (problem.laser) check_laser(problem);
  if (problem.survey) check_landmarks(problem);
  std::set<std::string> names;
  std::set<int> cameras_with_views;
  for (const TargetView& view : problem.views) cameras_with_views.insert(view.camera);
  for (int c = 0; c < static_cast<int>(problem.cameras.size()); ++c) {
    const ProblemCamera& camera = problem.cameras[c];
    check_camera(camera, cameras_with_views.contains(c));
    if (!names.insert(camera.name).second) refuse("two cameras are called '" + camera.name + "'; rename one");
  }
  std::ranges::for_each(problem.targets, check_target);
  refuse_boards_of_one_name(problem);
  for (int c = 0; c < static_cast<int>(problem.cameras.size()); ++c) {
    refuse_swapped_axes(problem, c);
    refuse_shares(problem, c);
  }
  std::set<std::tuple<int, int, int>> seen;
  for (std::size_t i = 0; i < problem.views.size(); ++i) {
    const TargetView& view = problem.views[i];
    if (!in_range(view.camera, problem.cameras.size()) || !in_range(view.frame, problem.frames.size()) ||
        !in_range(view.target, problem.targets.size())) {
      refuse("view " + std::to_string(i) + " names a camera, frame or target that does not exist");
    }
    const std::string where = view_name(problem, view);
    if (!seen.insert({view.camera, view.frame, view.target}).second) refuse("the view is given twice", where);
    for (const Observation& observation : view.observations) {
      check_observation(observation, problem.targets[view.target], problem.cameras[view.camera].size, where);
    }
    refuse_repeated_points(view, where);
    check_dots(view, problem.laser, where);
  }
  for (const ParameterRule& rule : problem.rules) {
    if (rule.value && !std::isfinite(*rule.value)) {
      refuse("the value for '" + rule.pattern + "' is not a finite number");
    }
    if (rule.kind == ParameterRule::Kind::kPrior && !(rule.sigma > 0)) {
      refuse("the prior on '" + rule.pattern + "' needs a positive sigma");
    }
  }
}

}  // namespace raybundle
