// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "detect_dots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <map>
#include <opencv2/imgproc.hpp>
#include <string_view>

#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/suggestion.hpp"
#include "raybundle/targets/laser_dots.hpp"

namespace raybundle::apps {
namespace {

// Outline of the corners of a view, convex.
std::vector<Eigen::Vector2d> outline_of(const TargetView& view) {
  std::vector<cv::Point2f> corners, hull;
  for (const Observation& observation : view.observations) {
    corners.emplace_back(static_cast<float>(observation.pixel.x()), static_cast<float>(observation.pixel.y()));
  }
  cv::convexHull(corners, hull);
  std::vector<Eigen::Vector2d> outline;
  for (const cv::Point2f& corner : hull) outline.emplace_back(corner.x, corner.y);
  return outline;
}

// The views of a camera by the frame that they belong to; several boards make several views.
std::map<std::string, std::vector<std::size_t>> views_by_frame(const CalibrationProblem& problem, int camera) {
  std::map<std::string, std::vector<std::size_t>> views;
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    if (problem.views[v].camera == camera) views[problem.frames[problem.views[v].frame]].push_back(v);
  }
  return views;
}

// Looks for dots on the board of a view. The image with the laser off is subtracted from the one with it on, unless they
// are the same.
//
// @returns why it could not be subtracted; nothing when it was, or need not be
std::string find_in(const cv::Mat& on, const std::string& on_path, CalibrationProblem& problem, std::size_t v) {
  TargetView& view = problem.views[v];
  std::string reason;
  const bool same = view.image.empty() || view.image == on_path;
  cv::Mat off = same ? cv::Mat() : read_gray(view.image, reason);
  if (!off.empty() && off.type() != on.type()) {
    reason =
        fmt::format("it has {} bits for a pixel, the one with the laser on {}", 8 * off.elemSize(), 8 * on.elemSize());
    off.release();
  }
  DotOptions options;
  options.region = outline_of(view);
  view.dots = find_dots(on, off.empty() ? nullptr : &off, options).dots;
  return reason;
}

// Dots of which the board's own picture was not taken away are found less well.
void hint_at_missing_partners(const Dataset& dataset, const std::vector<ImageFile>& files,
                              const std::vector<std::string>& not_subtracted, DetectedImages& images) {
  for (int c = 0; c < static_cast<int>(dataset.cameras.size()); ++c) {
    const auto concerns = [&](std::size_t f) { return files[f].camera == c && !not_subtracted[f].empty(); };
    int count = 0;
    std::size_t first = 0;
    for (std::size_t f = 0; f < files.size(); ++f) {
      if (concerns(f) && ++count == 1) first = f;
    }
    if (count == 0) continue;
    images.hints.push_back(
        fmt::format("camera {}: {} images with the laser off could not be subtracted from those with it on, as that of "
                    "{}: {}; take both with the same settings",
                    dataset.cameras[c].name, count, files[first].path, not_subtracted[first]));
  }
}

// A moment has one image with the laser off and one with it on: videos have no names by which their frames are paired.
void refuse_videos(int camera, const std::vector<ImageFile>& lit, const DetectedImages& images) {
  const auto is_its_video = [&](const ImageFile& file) { return file.camera == camera && file.video; };
  for (const std::vector<ImageFile>& files : {lit, images.files}) {
    const auto video = std::ranges::find_if(files, is_its_video);
    if (video == files.end()) continue;
    throw Error(ErrorKind::kBadInput,
                "is a video, of a camera with laser_on: save its frames as images, and give those of one moment with "
                "the laser off and on the same number",
                video->path);
  }
}

// Images with the laser on in which no dot was found on the board: a few miss it, many are no such images.
void hint_at_dark_images(const Dataset& dataset, const std::vector<ImageFile>& files,
                         const std::vector<std::vector<std::size_t>>& views_of_file,
                         const std::vector<std::string>& unreadable, DetectedImages& images) {
  constexpr double kMany = 0.25;
  const std::vector<TargetView>& views = images.observations.problem.views;
  for (int c = 0; c < static_cast<int>(dataset.cameras.size()); ++c) {
    int all = 0, dark = 0;
    std::string first;
    for (std::size_t f = 0; f < files.size(); ++f) {
      if (files[f].camera != c || !unreadable[f].empty()) continue;
      ++all;
      if (!std::ranges::all_of(views_of_file[f], [&](std::size_t v) { return views[v].dots.empty(); })) continue;
      if (++dark == 1) first = files[f].path;
    }
    if (all == 0 || dark < kMany * all || dark < 2) continue;
    images.hints.push_back(fmt::format(
        "camera {}: in {} of its {} images with the laser on no dot was found on the board, as in {}; are the "
        "images with the laser on and off swapped, or the same?",
        dataset.cameras[c].name, dark, all, first));
  }
}

// Image names pad the numbers of their frames: 003 is frame 3.
std::string_view without_zeros(std::string_view frame) {
  frame.remove_prefix(std::min(frame.find_first_not_of('0'), frame.size()));
  return frame;
}

// From a pixel to the nearest dot of a view; infinite without dots.
double distance_to_dots_px(const TargetView& view, const Eigen::Vector2d& pixel) {
  double nearest_px = std::numeric_limits<double>::infinity();
  for (const Dot& dot : view.dots) nearest_px = std::min(nearest_px, (dot.pixel - pixel).norm());
  return nearest_px;
}

}  // namespace

void add_dots(const Dataset& dataset, const DetectOptions& options, DetectedImages& images) {
  const auto begin = std::chrono::steady_clock::now();
  CalibrationProblem& problem = images.observations.problem;
  std::vector<ImageFile> files;
  std::vector<std::vector<std::size_t>> views_of_file;
  int alone = 0;
  for (int c = 0; c < static_cast<int>(dataset.cameras.size()); ++c) {
    if (dataset.cameras[c].laser_on.empty()) continue;
    const auto views = views_by_frame(problem, c);
    const std::vector<ImageFile> lit = image_files(c, dataset.folder, dataset.cameras[c].laser_on);
    refuse_videos(c, lit, images);
    for (const ImageFile& file : lit) {
      const auto found = views.find(file.frame);
      if (found == views.end()) {
        ++alone;
        continue;
      }
      files.push_back(file);
      views_of_file.push_back(found->second);
    }
  }
  if (files.empty()) {
    throw Error(
        ErrorKind::kNotEnoughData,
        fmt::format("none of the {} images of laser_on belongs to an image in which the board was found; do their "
                    "names differ from those of images in more than one part, as *_on.png and *_off.png?",
                    alone));
  }
  std::vector<std::string> other_size(files.size()), not_subtracted(files.size());
  std::vector<std::string> reasons =
      for_each_frame(files, options.threads, "finding dots", [&](std::size_t f, const cv::Mat& on, const std::string&) {
        const ImageSize size = problem.cameras[files[f].camera].size;
        if (size != ImageSize{on.cols, on.rows}) {
          other_size[f] = fmt::format("is {}x{} with the laser on, but the camera's images are {}x{}", on.cols, on.rows,
                                      size.width, size.height);
          return;
        }
        for (const std::size_t v : views_of_file[f]) not_subtracted[f] = find_in(on, files[f].path, problem, v);
      });
  for (std::size_t f = 0; f < files.size(); ++f) reasons[f] += other_size[f];  // one of them is empty
  for (std::size_t f = 0; f < files.size(); ++f) {
    if (!reasons[f].empty()) {
      images.unused.push_back({dataset.cameras[files[f].camera].name, files[f].frame, files[f].path, reasons[f]});
    }
  }
  hint_at_dark_images(dataset, files, views_of_file, reasons, images);
  hint_at_missing_partners(dataset, files, not_subtracted, images);
  images.laser_files = files;
  problem.laser = ProblemLaser{dataset.laser->grid, {}, dataset.laser->brightest, dataset.laser->missing};
  if (dataset.laser->anchor) set_anchor(*dataset.laser->anchor, problem);
  images.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void set_anchor(const DatasetAnchor& anchor, CalibrationProblem& problem) {
  if (!problem.laser) throw Error(ErrorKind::kBadInput, "there is an anchor, but no laser that it could belong to");
  const LaserGrid& grid = problem.laser->grid;
  if (anchor.row < 0 || anchor.row >= grid.rows || anchor.column < 0 || anchor.column >= grid.columns) {
    throw Error(
        ErrorKind::kBadInput,
        fmt::format("the anchor's beam, row {} and column {}, is not one of {} rows and {} columns, counted from 0",
                    anchor.row, anchor.column, grid.rows, grid.columns));
  }
  std::vector<std::string> cameras;
  for (const ProblemCamera& camera : problem.cameras) cameras.push_back(camera.name);
  if (std::ranges::find(cameras, anchor.camera) == cameras.end()) {
    throw Error(ErrorKind::kBadInput, fmt::format("the anchor names camera {}, which the data set does not have.{}",
                                                  anchor.camera, did_you_mean(anchor.camera, cameras)));
  }
  std::optional<LaserAnchor> found;
  double nearest_px = std::numeric_limits<double>::infinity();
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    const TargetView& view = problem.views[v];
    if (problem.cameras[view.camera].name != anchor.camera) continue;
    if (without_zeros(problem.frames[view.frame]) != without_zeros(anchor.frame)) continue;
    const double distance_px = distance_to_dots_px(view, anchor.pixel);
    if (found && !(distance_px < nearest_px)) continue;  // of several boards, the one whose dot is meant
    nearest_px = distance_px;
    found = LaserAnchor{static_cast<int>(v), anchor.pixel, grid.index(anchor.row, anchor.column)};
  }
  if (!found) {
    throw Error(ErrorKind::kBadInput,
                fmt::format("the anchor is in frame {} of camera {}, in which no board was found; "
                            "name a dot in another image",
                            anchor.frame, anchor.camera));
  }
  problem.laser->anchor = found;
}

}  // namespace raybundle::apps
