// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "repeated_views.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>

namespace raybundle::apps {
namespace {

// Views that can be the same: of one camera and board, with as many corners, the first at the same pixel.
using Likeness = std::tuple<int, int, std::size_t, double, double>;

bool same_corners(const TargetView& a, const TargetView& b) {
  return std::ranges::equal(a.observations, b.observations, [](const Observation& one, const Observation& other) {
    return one.point_id == other.point_id && one.pixel == other.pixel;
  });
}

}  // namespace

void leave_out_repeated_views(DetectedImages& images) {
  CalibrationProblem& problem = images.observations.problem;
  std::map<Likeness, std::vector<TargetView>> seen;
  std::vector<TargetView> kept;
  for (TargetView& view : problem.views) {
    if (view.observations.empty()) {
      kept.push_back(std::move(view));
      continue;
    }
    const Eigen::Vector2d& first = view.observations.front().pixel;
    std::vector<TargetView>& alike = seen[{view.camera, view.target, view.observations.size(), first.x(), first.y()}];
    const auto same = std::ranges::find_if(alike, [&](const TargetView& other) { return same_corners(view, other); });
    if (same == alike.end()) {
      alike.push_back(view);
      kept.push_back(std::move(view));
      continue;
    }
    // Without its file, the image is not looked at again for corners that a first solve predicts.
    std::erase_if(images.files, [&](const ImageFile& file) { return !file.video && file.path == view.image; });
    const std::string image = view.image.empty() ? view_name(problem, view) : view.image;
    images.unused.push_back({problem.cameras[view.camera].name, problem.frames[view.frame], image,
                             fmt::format("shows exactly what frame {} shows: the same image twice, or a frozen camera",
                                         problem.frames[same->frame])});
  }
  problem.views = std::move(kept);
}

}  // namespace raybundle::apps
