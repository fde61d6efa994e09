// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "predicted_corners.hpp"

#include <algorithm>
#include <map>
#include <mutex>
#include <set>
#include <tuple>

#include "raybundle/targets/detect.hpp"

namespace raybundle::apps {
namespace {

using ViewKey = std::tuple<int, int, int>;  // camera, frame, target

// All board points that the camera should see.
std::vector<Observation> predict(const Camera& camera, const Rigid3& camera_from_target,
                                 const CalibratedTarget& calibrated) {
  const std::vector<Eigen::Vector3d> points = points_on_surface(calibrated.target, calibrated.shape);
  const double max_angle = max_angle_rad(camera);
  std::vector<Observation> predicted;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d x = camera_from_target * points[i];
    if (angle_off_axis(x) >= max_angle) continue;  // folds back into the image
    const std::optional<Eigen::Vector2d> pixel = pixel_from_ray(camera, x);
    const bool inside = pixel && pixel->x() > 0 && pixel->y() > 0 && pixel->x() < camera.size.width - 1 &&
                        pixel->y() < camera.size.height - 1;
    if (inside) predicted.push_back({*pixel, 1.0, calibrated.target.points[i].id});
  }
  return predicted;
}

// Where the board of a view stood: as the view itself told, or as another camera saw it at that moment.
const BoardPose* pose_of(const CalibrationResult& result, const std::map<ViewKey, int>& views, const ViewKey& key) {
  const auto view = views.find(key);
  if (view != views.end()) {
    const int pose = result.views[view->second].pose;
    return pose >= 0 ? &result.poses[pose] : nullptr;
  }
  const auto other = std::ranges::find_if(result.poses, [&](const BoardPose& pose) {
    return pose.frame == std::get<1>(key) && pose.target == std::get<2>(key);
  });
  return other != result.poses.end() ? &*other : nullptr;
}

// Corners under the ids that the detector gave the view, which the solve may have relabelled.
std::vector<Observation> as_detected(std::vector<Observation> corners, const Target& target, int symmetry) {
  if (symmetry < 0) return corners;
  const std::vector<int>& ids = target.symmetries[symmetry].ids;
  for (Observation& corner : corners) {
    corner.point_id = target.points[std::ranges::find(ids, corner.point_id) - ids.begin()].id;
  }
  return corners;
}

// Adds those refined corners that the view does not have yet.
int add_missing(TargetView& view, const std::vector<Observation>& refined) {
  std::set<int> known;
  for (const Observation& observation : view.observations) known.insert(observation.point_id);
  int added = 0;
  for (const Observation& observation : refined) {
    if (!known.insert(observation.point_id).second) continue;
    view.observations.push_back(observation);
    ++added;
  }
  std::ranges::sort(view.observations, {}, &Observation::point_id);
  return added;
}

}  // namespace

int add_predicted_corners(const Dataset& dataset, const CalibrationResult& result, DetectedImages& images,
                          const DetectOptions& options) {
  CalibrationProblem& problem = images.observations.problem;
  std::map<ViewKey, int> views;
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    views[{problem.views[v].camera, problem.views[v].frame, problem.views[v].target}] = static_cast<int>(v);
  }
  std::map<std::string, const RigCamera*> cameras;
  for (const RigCamera& camera : result.calibration.cameras) cameras[camera.name] = &camera;
  std::map<std::string, int> frames;
  for (std::size_t f = 0; f < problem.frames.size(); ++f) frames[problem.frames[f]] = static_cast<int>(f);

  struct Refined {
    std::string image;
    std::vector<Observation> corners;
  };
  // The pose of a board that lacks corners in an image; nullptr when it has all of them, or nobody knows where it was.
  const auto pose_of_incomplete = [&](const ViewKey& key) -> const BoardPose* {
    const auto view = views.find(key);
    const std::size_t known = view == views.end() ? 0 : problem.views[view->second].observations.size();
    if (known == problem.targets[std::get<2>(key)].points.size()) return nullptr;
    return pose_of(result, views, key);
  };
  std::vector<ImageFile> files;  // to be read again: not those in which nothing is missing
  for (const ImageFile& file : images.files) {
    bool any = file.video;
    const auto frame = frames.find(file.frame);
    for (int t = 0; frame != frames.end() && t < static_cast<int>(problem.targets.size()); ++t) {
      any = any || pose_of_incomplete({file.camera, frame->second, t}) != nullptr;
    }
    if (any) files.push_back(file);
  }
  std::mutex guard;
  std::map<ViewKey, Refined> refined;
  const auto refine = [&](std::size_t file, const cv::Mat& gray, const std::string& frame) {
    const int c = files[file].camera;
    const auto camera = cameras.find(problem.cameras[c].name);
    if (camera == cameras.end()) return;
    for (int t = 0; t < static_cast<int>(problem.targets.size()); ++t) {
      const ViewKey key{c, frames.at(frame), t};
      const BoardPose* pose = pose_of_incomplete(key);
      if (pose == nullptr) continue;
      const RigCamera& rig_camera = *camera->second;
      if (rig_camera.camera.size != ImageSize{gray.cols, gray.rows}) return;  // left out before
      const std::vector<Observation> predicted =
          predict(rig_camera.camera, rig_camera.camera_from_rig * pose->rig_from_target, result.calibration.targets[t]);
      std::vector<Observation> corners = refine_predicted(dataset.boards[t].board, gray, predicted);
      const std::scoped_lock lock(guard);
      refined[key] = {files[file].path, std::move(corners)};
    }
  };
  for_each_frame(files, options.threads, "refining", refine);

  int added = 0;
  for (const auto& [key, found] : refined) {
    const auto view = views.find(key);
    if (view != views.end()) {
      TargetView& known = problem.views[view->second];
      const int symmetry = result.views[view->second].symmetry;
      added += add_missing(known, as_detected(found.corners, problem.targets[known.target], symmetry));
    } else if (found.corners.size() >= 4) {
      problem.views.push_back({std::get<0>(key), std::get<1>(key), std::get<2>(key), found.corners, found.image});
      added += static_cast<int>(found.corners.size());
      const std::string& camera = problem.cameras[std::get<0>(key)].name;
      const std::string& frame = problem.frames[std::get<1>(key)];
      std::erase_if(images.unused, [&camera, &frame](const UnusedImage& unused) {
        return unused.camera == camera && unused.frame == frame;
      });
    }
  }
  return added;
}

}  // namespace raybundle::apps
