// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "motion_findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "raybundle/geometry/quantile.hpp"
#include "raybundle/uncertainty/frame_repetition.hpp"
#include "raybundle/uncertainty/rolling_shutter.hpp"

namespace raybundle {
namespace {

constexpr std::size_t kNamedViews = 6;
constexpr double kApartByChance = 0.1;  // of the frames: a board that was moved once, not cameras out of step
constexpr double kWorthTelling = 0.7;   // of the frames: above, repetition makes sigmas too small by less than a fifth

// "20, 22 and 23"; the first of many.
std::string frame_names(const CalibrationProblem& problem, const std::vector<RowTiming>& timings) {
  std::string text;
  const std::size_t named = std::min(timings.size(), kNamedViews);
  for (std::size_t i = 0; i < named; ++i) {
    const bool last = i + 1 == timings.size();
    text += i == 0 ? "" : last ? " and " : ", ";
    text += problem.frames[problem.views[timings[i].view].frame];
  }
  return named == timings.size() ? text : text + fmt::format(" and {} more", timings.size() - named);
}

template <typename Member>
double median_of(const std::vector<RowTiming>& timings, Member member) {
  std::vector<double> values;
  for (const RowTiming& timing : timings) values.push_back(timing.*member);
  return median(values);
}

}  // namespace

std::optional<Finding> shutter_finding(const CalibrationProblem& problem, const CalibrationResult& result, int camera) {
  const std::string& name = problem.cameras[camera].name;
  // A lens that is held at another centre shows in its views what a shutter does.
  const std::vector<int> of_centre = result.calibration.covariance.places_of({name + ".cx", name + ".cy"});
  if (std::ranges::count(of_centre, -1) > 0) return std::nullopt;
  std::vector<RowTiming> timings = row_timings(problem, result, camera);
  if (timings.empty()) return std::nullopt;
  if (!is_rolling(timings)) {
    return Finding{name, "shutter", true, fmt::format("no sign of a rolling shutter in {} views", timings.size()), {}};
  }
  std::erase_if(timings, [](const RowTiming& timing) { return !timing.rows; });
  return Finding{
      name, "shutter", false,
      fmt::format("the views of frames {} fit to {:.2f} px instead of {:.2f} when each row of the image has a "
                  "time of its own, while the best of anything else leaves {:.2f}: a rolling shutter, and the "
                  "board or the camera moved",
                  frame_names(problem, timings), median_of(timings, &RowTiming::by_rows_px),
                  median_of(timings, &RowTiming::rms_px), median_of(timings, &RowTiming::otherwise_px)),
      "hold board and camera still for each image, or leave these views out"};
}

std::optional<Finding> sync_finding(const CalibrationProblem& problem, const CalibrationResult& result) {
  std::map<int, std::set<int>> cameras_of_frame;
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    if (result.views[v].pose >= 0) cameras_of_frame[problem.views[v].frame].insert(problem.views[v].camera);
  }
  const auto saw_several = [&](int frame) { return cameras_of_frame[frame].size() > 1; };
  const auto shared =
      std::ranges::count_if(cameras_of_frame, [](const auto& frame) { return frame.second.size() > 1; });
  if (shared == 0) return std::nullopt;
  std::set<int> apart;
  for (const SetAside& each : result.set_aside) {
    const int frame = problem.views[each.view].frame;
    if (each.scope == SetAside::Scope::kExtrinsics && saw_several(frame)) apart.insert(frame);
  }
  const bool good = static_cast<double>(apart.size()) <= kApartByChance * static_cast<double>(shared);
  return Finding{"the rig", "sync", good,
                 fmt::format("in {} of {} frames that several cameras saw they agree about where the board was",
                             static_cast<std::size_t>(shared) - apart.size(), shared),
                 good ? "" : "trigger the cameras together, or keep the board still until all have taken their image"};
}

std::optional<Finding> repetition_finding(const CalibrationProblem& problem, const CalibrationResult& result) {
  const FrameRepetition found = frame_repetition(problem, result);
  if (found.correlation == 0.0) return std::nullopt;
  const bool good = found.worth > kWorthTelling * found.frames;
  return Finding{
      "the data", "repetition", good,
      fmt::format("{} the board in the same place, where {:.0f} % of their errors are the same: {} poses of the board "
                  "tell as much as {:.0f} in places of their own",
                  found.pairs == 1 ? "1 pair of frames shows" : fmt::format("{} pairs of frames show", found.pairs),
                  100 * found.correlation, found.frames, found.worth),
      good ? "" : "move and tilt the board from image to image; more images of the same pose tell little"};
}

}  // namespace raybundle
