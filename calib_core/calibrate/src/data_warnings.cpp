// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/calibrate/data_warnings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "raybundle/calibrate/linking_frames.hpp"
#include "raybundle/scene/target_spacing.hpp"
#include "raybundle/uncertainty/frame_covariance.hpp"

namespace raybundle {
namespace {

constexpr double kSamePlace_m = 1e-3;
constexpr double kUpsideDown_rad = 0.75 * M_PI;
constexpr double kWidestSpacing_m = 1.0;      // boards are carried by hand
constexpr double kNarrowestSpacing_m = 2e-4;  // and their points are told apart by eye

// Whether most corners of a view are in another one at the very same pixels, which two cameras never give. Not all of
// them: what a first solve predicts is refined from where each camera's lens puts it.
bool same_image(const TargetView& a, const TargetView& b) {
  using Corner = std::tuple<int, double, double>;
  const auto corners_of = [](const TargetView& view) {
    std::vector<Corner> corners;
    for (const Observation& seen : view.observations)
      corners.emplace_back(seen.point_id, seen.pixel.x(), seen.pixel.y());
    if (!std::ranges::is_sorted(corners)) std::ranges::sort(corners);
    return corners;
  };
  std::vector<Corner> same;
  if (a.target == b.target) std::ranges::set_intersection(corners_of(a), corners_of(b), std::back_inserter(same));
  return 2 * same.size() > a.observations.size();
}

using FramesOfCameras = std::map<std::pair<int, int>, std::set<int>>;

// Pairs of cameras that were given the same images.
std::vector<std::string> shared_image_warnings(const CalibrationProblem& problem) {
  std::map<int, std::vector<const TargetView*>> views_of_frame;
  FramesOfCameras frames;  // that show the same
  for (const TargetView& view : problem.views) {
    for (const TargetView* other : views_of_frame[view.frame]) {
      if (other->camera == view.camera || !same_image(view, *other)) continue;
      frames[std::minmax(other->camera, view.camera)].insert(view.frame);
    }
    views_of_frame[view.frame].push_back(&view);
  }
  std::vector<std::string> warnings;
  for (const auto& [cameras, same] : frames) {
    warnings.push_back(
        fmt::format("{} and {} have corners at exactly the same pixels in {} frames, such as {}: the images of one "
                    "camera were given as the other's, too, and where one is from the other means nothing; check the "
                    "image patterns",
                    problem.cameras[cameras.first].name, problem.cameras[cameras.second].name, same.size(),
                    problem.frames[*same.begin()]));
  }
  return warnings;
}

// Cameras called left and right of which one hangs upside down, or that lie the other way round: their images were
// exchanged, or both hang upside down.
std::string sides_warning(const Calibration& calibration) {
  const auto named = [&](const char* name) { return std::ranges::find(calibration.cameras, name, &RigCamera::name); };
  const auto left = named("left"), right = named("right");
  if (left == calibration.cameras.end() || right == calibration.cameras.end()) return {};
  const Rigid3 left_from_right = left->camera_from_rig * right->camera_from_rig.inverse();
  const Eigen::Matrix3d turn = left_from_right.rotation.toRotationMatrix();
  const double about_sight_rad = std::atan2(turn(1, 0) - turn(0, 1), turn(0, 0) + turn(1, 1));
  if (std::abs(about_sight_rad) > kUpsideDown_rad) {
    return fmt::format(
        "left and right are turned by {:.0f}° against each other about their line of sight: does one of them hang upside "
        "down, or were its images turned?",
        std::abs(about_sight_rad) * 180.0 / M_PI);
  }
  const Eigen::Vector3d& right_in_left = left_from_right.translation;
  if (right_in_left.x() >= -std::max(right_in_left.tail<2>().norm(), kSamePlace_m)) return {};
  return fmt::format(
      "right lies {:.0f} mm to the left of left: are their images exchanged, or do both cameras hang upside down?",
      -1e3 * right_in_left.x());
}

// What few frames say of a rig, no other frame tests.
std::string few_links_warning(const CalibrationProblem& problem, const CalibrationResult& result) {
  const auto [shared, linking] = linking_frames(problem, result);
  if (result.calibration.cameras.size() < 2 || 2 * linking >= shared) return {};
  return fmt::format(
      "only {} of the {} frames in which several cameras saw the board link them: in the others it stood elsewhere for "
      "each, as when cameras do not expose together, the board moves, or images of some frames are turned, cropped, or "
      "numbered otherwise; hold it still or synchronise the cameras, and trust less what is said of where they are",
      linking, shared);
}

// Cameras that stand in the same place and look the same way, as no two can: images of one that were saved twice.
std::vector<std::string> same_place_warnings(const Calibration& calibration) {
  constexpr double kSameDirection_rad = 2e-3;
  std::vector<std::string> warnings;
  for (std::size_t a = 0; a < calibration.cameras.size(); ++a) {
    for (std::size_t b = a + 1; b < calibration.cameras.size(); ++b) {
      const RigCamera &first = calibration.cameras[a], &second = calibration.cameras[b];
      const Rigid3 second_from_first = second.camera_from_rig * first.camera_from_rig.inverse();
      const double away_m = second_from_first.translation.norm();
      if (away_m > kSamePlace_m || angle_between(second_from_first, Rigid3{}) > kSameDirection_rad) continue;
      warnings.push_back(
          fmt::format("{} and {} stand in the same place, {:.2f} mm apart: are the images of one camera given twice?",
                      first.name, second.name, 1e3 * away_m));
    }
  }
  return warnings;
}

// Frames that do not link two cameras as they are, but would if their images were exchanged.
FramesOfCameras exchanged_frames(const CalibrationProblem& problem, const CalibrationResult& result) {
  constexpr double kPlainlyNearer = 0.35;  // each image was posed with the other camera's lens
  const auto camera_from_rig = [&](int view) -> const Rigid3& {
    return camera_named(result.calibration, problem.cameras[problem.views[view].camera].name).camera_from_rig;
  };
  const auto camera_from_target = [&](int view) {
    return camera_from_rig(view) * result.poses[result.views[view].pose].rig_from_target;
  };
  const auto distance_m = [](const Rigid3& a, const Rigid3& b) { return (a.translation - b.translation).norm(); };
  std::map<std::pair<int, int>, std::vector<int>> posed_views;  // of each frame and board
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    if (result.views[v].pose >= 0) posed_views[{problem.views[v].frame, problem.views[v].target}].push_back(v);
  }
  FramesOfCameras frames;
  for (const SetAside& aside : result.set_aside) {
    const TargetView& here = problem.views[aside.view];
    if (aside.scope != SetAside::Scope::kExtrinsics || result.views[aside.view].pose < 0) continue;
    for (const int v : posed_views[{here.frame, here.target}]) {
      if (problem.views[v].camera == here.camera) continue;
      const Rigid3 there_from_here = camera_from_rig(v) * camera_from_rig(aside.view).inverse();
      const double apart_m = distance_m(there_from_here * camera_from_target(aside.view), camera_from_target(v));
      const double exchanged_m = distance_m(there_from_here * camera_from_target(v), camera_from_target(aside.view));
      if (exchanged_m < kPlainlyNearer * apart_m) {
        frames[std::minmax(here.camera, problem.views[v].camera)].insert(here.frame);
      }
    }
  }
  return frames;
}

std::vector<std::string> exchanged_frames_warnings(const CalibrationProblem& problem, const CalibrationResult& result) {
  constexpr std::size_t kMostNamed = 20;  // frames
  std::vector<std::string> warnings;
  for (const auto& [cameras, exchanged] : exchanged_frames(problem, result)) {
    std::vector<std::string> names;
    for (const int frame : exchanged) names.push_back(problem.frames[frame]);
    const bool all_named = names.size() <= kMostNamed;
    names.resize(std::min(names.size(), kMostNamed));
    warnings.push_back(fmt::format(
        "the images of {} and {} look exchanged in frame{} {}{}: each board lies where the other camera would see it; "
        "exchange them, and these frames link the cameras, too",
        problem.cameras[cameras.first].name, problem.cameras[cameras.second].name, exchanged.size() == 1 ? "" : "s",
        fmt::join(names, ", "), all_named ? "" : ", ..."));
  }
  return warnings;
}

// Of few views every sigma may be several times too small: how frames disagree is what tests it.
std::string few_views_warning(const ProblemCamera& camera, const CameraSummary& summary) {
  const int views = summary.views_used;
  if (views >= kFewestFrames || summary.views_total == 0) return {};
  if (views == 0) {
    return fmt::format("camera {} stands on no view at all: none of its {} fits, and nothing is known of it",
                       camera.name, summary.views_total);
  }
  const int others = summary.views_total - views;
  return fmt::format(
      "camera {} stands on {} views only{}, too few to show what the lens does in the whole image: nothing tests the "
      "model, and the sigmas may be several times too small; take 15 to 30, near and far, tilted, and into every corner",
      camera.name, views, others > 0 ? fmt::format(" ({} others are set aside)", others) : "");
}

// Detectors err by tenths of a pixel and the worst choice of a lens by a few pixels. Beyond, the corners are not those of
// the board that was asked for.
std::string misfit_warning(const ProblemCamera& camera, const CameraSummary& summary) {
  constexpr double kGross_px = 4.0;
  constexpr double kGrossShare = 1e-3;  // of the image's longer side
  const double gross_px = std::max(kGross_px, kGrossShare * std::max(camera.size.width, camera.size.height));
  if (!(summary.rms_px > gross_px)) return {};
  return fmt::format(
      "the corners of {} lie {:.1f} px off, root mean square, where detectors err by tenths of a pixel: is the board the "
      "one that was asked for, its kind, its counts and its measures? Is it flat? Does the model suit the lens?",
      camera.name, summary.rms_px);
}

// Views that were set aside and reach where no other view of their camera does.
std::vector<std::string> lonely_view_warnings(const CalibrationProblem& problem, const CalibrationResult& result) {
  std::map<int, std::set<int>> frames;  // by camera
  for (const SetAside& aside : result.set_aside) {
    const TargetView& view = problem.views[aside.view];
    const ProblemCamera& camera = problem.cameras[view.camera];
    const auto found = std::ranges::find(result.calibration.cameras, camera.name, &RigCamera::name);
    if (aside.scope != SetAside::Scope::kView || found == result.calibration.cameras.end() || !found->evidence)
      continue;
    const auto alone = std::ranges::count_if(view.observations, [&](const Observation& corner) {
      return !found->evidence->covers(camera.size, corner.pixel);
    });
    if (2 * alone > std::ssize(view.observations)) frames[view.camera].insert(view.frame);
  }
  std::vector<std::string> warnings;
  for (const auto& [camera, alone] : frames) {
    warnings.push_back(fmt::format(
        "{} of the views of {} that are set aside, such as frame {}, {} where no view in use does: either {} bad, or the "
        "lens that fits the others is wrong there, and nothing tells which; take more images there",
        alone.size(), problem.cameras[camera].name, problem.frames[*alone.begin()],
        alone.size() == 1 ? "reaches" : "reach", alone.size() == 1 ? "it is" : "they are"));
  }
  return warnings;
}

}  // namespace

std::string unit_warning(const Target& target) {
  const double spacing = spacing_m(target);
  if (spacing >= kNarrowestSpacing_m && spacing <= kWidestSpacing_m) return {};
  return fmt::format(
      "the points of {} lie {:.6g} m apart: is the unit right (25mm in a word, 0.025 in square_m)? The baseline and "
      "the poses are wrong by the same factor as the board",
      target.name, spacing);
}

std::vector<std::string> data_warnings(const CalibrationProblem& problem, const CalibrationResult& result) {
  std::vector<std::string> warnings;
  for (const Target& target : problem.targets) {
    if (const std::string warning = unit_warning(target); !warning.empty()) warnings.push_back(warning);
  }
  std::vector<std::string> one_camera_twice = shared_image_warnings(problem);
  if (one_camera_twice.empty()) one_camera_twice = same_place_warnings(result.calibration);
  std::ranges::move(one_camera_twice, std::back_inserter(warnings));
  if (std::string warning = sides_warning(result.calibration); !warning.empty()) {
    warnings.push_back(std::move(warning));
  }
  std::ranges::copy(exchanged_frames_warnings(problem, result), std::back_inserter(warnings));
  if (std::string warning = few_links_warning(problem, result); !warning.empty()) {
    warnings.push_back(std::move(warning));
  }
  for (std::size_t c = 0; c < problem.cameras.size(); ++c) {
    for (const auto& warning_of : {few_views_warning, misfit_warning}) {
      if (std::string warning = warning_of(problem.cameras[c], result.cameras[c]); !warning.empty()) {
        warnings.push_back(std::move(warning));
      }
    }
  }
  std::ranges::copy(lonely_view_warnings(problem, result), std::back_inserter(warnings));
  return warnings;
}

}  // namespace raybundle
