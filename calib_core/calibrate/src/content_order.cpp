// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "content_order.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

namespace raybundle {
namespace {

std::vector<int> indices(std::size_t count) {
  std::vector<int> result(count);
  std::iota(result.begin(), result.end(), 0);
  return result;
}

/// @param indices  each once
template <typename T>
std::vector<T> at(std::vector<T> values, const std::vector<int>& indices) {
  std::vector<T> result;
  result.reserve(indices.size());
  for (const int i : indices) result.push_back(std::move(values[i]));
  return result;
}

/// The inverse of at(); without indices values are where they were.
template <typename T>
std::vector<T> put_back(std::vector<T> values, const std::vector<int>& indices) {
  if (indices.empty()) return values;
  std::vector<T> result(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) result[indices[i]] = std::move(values[i]);
  return result;
}

/// Order of two views whose corners are sorted: by what was seen, then by camera and target. Two views that are the
/// same in all of that may change places without a trace.
bool before(const TargetView& a, const TargetView& b) {
  const auto key = [](const Observation& o) { return std::tuple(o.point_id, o.pixel.x(), o.pixel.y(), o.sigma_px); };
  const std::size_t common = std::min(a.observations.size(), b.observations.size());
  for (std::size_t i = 0; i < common; ++i) {
    if (key(a.observations[i]) != key(b.observations[i])) return key(a.observations[i]) < key(b.observations[i]);
  }
  return std::tuple(a.observations.size(), a.target, a.camera) < std::tuple(b.observations.size(), b.target, b.camera);
}

}  // namespace

OrderedProblem in_order_of_content(const CalibrationProblem& given) {
  OrderedProblem ordered;
  ordered.problem = given;
  std::vector<std::vector<int>> observations, dots;
  for (TargetView& view : ordered.problem.views) {
    std::vector<int>& order_of_dots = dots.emplace_back(indices(view.dots.size()));
    std::ranges::stable_sort(order_of_dots, {},
                             [&](int i) { return std::pair(view.dots[i].pixel.x(), view.dots[i].pixel.y()); });
    view.dots = at(view.dots, order_of_dots);
    std::vector<int>& order = observations.emplace_back();
    if (std::ranges::is_sorted(view.observations, {}, &Observation::point_id)) continue;
    order = indices(view.observations.size());
    std::ranges::stable_sort(order, {}, [&](int i) { return view.observations[i].point_id; });
    view.observations = at(view.observations, order);
  }
  ordered.views = indices(given.views.size());
  std::ranges::stable_sort(ordered.views,
                           [&](int a, int b) { return before(ordered.problem.views[a], ordered.problem.views[b]); });
  ordered.problem.views = at(std::move(ordered.problem.views), ordered.views);
  ordered.observations = at(observations, ordered.views);
  ordered.dots = at(dots, ordered.views);
  if (given.laser && given.laser->anchor) {
    const auto anchored = std::ranges::find(ordered.views, given.laser->anchor->view);
    ordered.problem.laser->anchor->view = static_cast<int>(anchored - ordered.views.begin());
  }

  std::vector<int> new_frame(given.frames.size(), -1);
  for (TargetView& view : ordered.problem.views) {
    if (new_frame[view.frame] < 0) {
      new_frame[view.frame] = static_cast<int>(ordered.frames.size());
      ordered.frames.push_back(view.frame);
    }
    view.frame = new_frame[view.frame];
  }
  for (int f = 0; f < static_cast<int>(given.frames.size()); ++f) {
    if (new_frame[f] < 0) ordered.frames.push_back(f);
  }
  ordered.problem.frames = at(given.frames, ordered.frames);
  return ordered;
}

CalibrationResult in_given_order(const OrderedProblem& ordered, CalibrationResult result) {
  for (BoardPose& pose : result.poses) pose.frame = ordered.frames[pose.frame];
  std::vector<int> poses = indices(result.poses.size());
  std::ranges::stable_sort(poses, {}, [&](int p) { return std::tuple(result.poses[p].frame, result.poses[p].target); });
  result.poses = at(result.poses, poses);
  std::vector<int> new_pose(poses.size());
  for (std::size_t p = 0; p < poses.size(); ++p) new_pose[poses[p]] = static_cast<int>(p);

  for (std::size_t v = 0; v < result.views.size(); ++v) {
    ViewResult& view = result.views[v];
    if (view.pose >= 0) view.pose = new_pose[view.pose];
    view.residuals_px = put_back(std::move(view.residuals_px), ordered.observations[v]);
    view.fates = put_back(std::move(view.fates), ordered.observations[v]);
    view.beam_of_dot = put_back(std::move(view.beam_of_dot), ordered.dots[v]);
    view.dot_fates = put_back(std::move(view.dot_fates), ordered.dots[v]);
    view.dot_residuals_px = put_back(std::move(view.dot_residuals_px), ordered.dots[v]);
  }
  result.views = put_back(std::move(result.views), ordered.views);
  for (SetAside& aside : result.set_aside) aside.view = ordered.views[aside.view];
  std::ranges::stable_sort(result.set_aside, {}, &SetAside::view);
  return result;
}

}  // namespace raybundle
