// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/frame_repetition.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <tuple>

#include "pose_information.hpp"
#include "raybundle/geometry/threads.hpp"
#include "raybundle/uncertainty/corner_evidence.hpp"
#include "sensitivity.hpp"

namespace raybundle {
namespace {

constexpr double kMaterial = 0.1;      // correlation below which sums over frames grow hardly faster than by chance
constexpr double kBeyondChance = 5.0;  // standard deviations of a correlation
constexpr int kFewestCommon = 6;       // corners by which two frames are held against each other

// A corner in the image of a frame. Its place on the board tells which it is, whatever its label was.
struct Corner {
  int camera = 0, target = 0;
  double x = 0.0, y = 0.0;          // on the board [m]
  Eigen::Vector2d pixel, residual;  // the residual whitened
  Eigen::Index row = 0;             // the first of two, among the frame's rows

  auto which() const { return std::tie(camera, target, y, x); }
};

using Frame = std::vector<Corner>;  // sorted by which()

void append(const ViewData& view, const Eigen::VectorXd& residual, Frame& frame) {
  const auto before = static_cast<Eigen::Index>(frame.size());
  frame.reserve(frame.size() + static_cast<std::size_t>(view.pixel.rows()));
  for (Eigen::Index i = 0; i < view.pixel.rows(); ++i) {
    frame.push_back({view.camera, view.target, view.points->x_in_target(i, 0), view.points->x_in_target(i, 1),
                     view.pixel.row(i), residual.segment<2>(2 * i), 2 * (before + i)});
  }
}

// Whitened residuals of a view's corners in use, one after the other.
Eigen::VectorXd whitened(const std::vector<Eigen::Vector2d>& residuals_px, const std::vector<ObservationFate>& fates,
                         const ViewData& data) {
  Eigen::VectorXd residual(2 * data.pixel.rows());
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < fates.size(); ++i) {
    if (fates[i] != ObservationFate::kUsed) continue;
    residual.segment<2>(2 * row) = residuals_px[i] * data.inverse_sigma[row];
    ++row;
  }
  return residual;
}

void sort(Frame& frame) {
  if (!std::ranges::is_sorted(frame, {}, &Corner::which)) std::ranges::sort(frame, {}, &Corner::which);
}

// Calls seen(a, b) for each corner that both frames show, until it answers no.
template <typename Seen>
void for_common_corners(const Frame& a, const Frame& b, const Seen& seen) {
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
    if (i->which() < j->which()) {
      ++i;
    } else if (j->which() < i->which()) {
      ++j;
    } else if (!seen(*i++, *j++)) {
      return;
    }
  }
}

// The corners in use of each pose.
std::vector<Frame> frames_of(const CalibrationProblem& problem, const BundleState& state) {
  std::vector<Frame> frames(state.poses.size());
  for (ViewData& view : used_views(problem, state)) {
    const std::vector<Eigen::Vector2d> residuals_px = view_residuals(problem, state, view.view);
    append(view, whitened(residuals_px, state.fates[view.view], view), frames[view.pose]);
    view = {};  // never all of both
  }
  std::ranges::for_each(frames, sort);
  return frames;
}

// Frames by their indices that show the board in the same place, and how alike their errors are.
struct Repeats {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  double correlation = 0.0;
};

bool same_place(const Frame& a, const Frame& b, const std::vector<double>& cell_px) {
  int common = 0;
  bool near = true;
  for_common_corners(a, b, [&](const Corner& one, const Corner& other) {
    near = (one.pixel - other.pixel).norm() <= cell_px[one.camera];
    ++common;
    return near;
  });
  return near && common >= kFewestCommon && 2 * static_cast<std::size_t>(common) >= std::max(a.size(), b.size());
}

Repeats repeats_among(const std::vector<Frame>& frames, const std::vector<double>& cell_px) {
  Repeats repeats;
  double products = 0.0, squares_a = 0.0, squares_b = 0.0, count = 0.0;
  for (std::size_t a = 0; a < frames.size(); ++a) {
    for (std::size_t b = a + 1; b < frames.size(); ++b) {
      if (!same_place(frames[a], frames[b], cell_px)) continue;
      repeats.pairs.emplace_back(a, b);
      for_common_corners(frames[a], frames[b], [&](const Corner& one, const Corner& other) {
        products += one.residual.dot(other.residual);
        squares_a += one.residual.squaredNorm();
        squares_b += other.residual.squaredNorm();
        count += 2.0;
        return true;
      });
    }
  }
  if (!(squares_a > 0.0 && squares_b > 0.0)) return repeats;
  const double correlation = products / std::sqrt(squares_a * squares_b);
  if (correlation > std::max(kMaterial, kBeyondChance / std::sqrt(count))) repeats.correlation = correlation;
  return repeats;
}

double cell_of(ImageSize size) { return std::max(size.width, size.height) / static_cast<double>(kEvidenceCells); }

// What a state says, with the names of parameters for those that its rows are wanted by.
Calibration calibration_of(const CalibrationProblem& problem, const BundleState& state,
                           const std::vector<std::string>& names) {
  Calibration calibration;
  calibration.covariance.names = names;
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    calibration.cameras.push_back({problem.cameras[c].name, state.cameras[c], state.camera_from_rig[c]});
  }
  for (std::size_t t = 0; t < problem.targets.size(); ++t) {
    calibration.targets.push_back({problem.targets[t], state.shapes[t]});
  }
  return calibration;
}

// Rows of the corners that two frames share, in the same order.
std::pair<Eigen::MatrixXd, Eigen::MatrixXd> common_rows(const Frame& a, const Eigen::MatrixXd& rows_a, const Frame& b,
                                                        const Eigen::MatrixXd& rows_b) {
  std::vector<Eigen::Index> of_a, of_b;
  for_common_corners(a, b, [&](const Corner& one, const Corner& other) {
    for (int axis = 0; axis < 2; ++axis) {
      of_a.push_back(one.row + axis);
      of_b.push_back(other.row + axis);
    }
    return true;
  });
  return {rows_a(of_a, Eigen::all), rows_b(of_b, Eigen::all)};
}

}  // namespace

FrameRepetition frame_repetition(const CalibrationProblem& problem, const CalibrationResult& result) {
  std::vector<Frame> frames(result.poses.size());
  std::vector<double> cell_px;
  for (const ProblemCamera& camera : problem.cameras) cell_px.push_back(cell_of(camera.size));
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    const ViewResult& view = result.views[v];
    if (view.pose < 0) continue;
    const ViewData data = used_corners(problem, result, v, problem.views[v].camera);
    append(data, whitened(view.residuals_px, view.fates, data), frames[view.pose]);
  }
  std::ranges::for_each(frames, sort);
  const Repeats repeats = repeats_among(frames, cell_px);
  FrameRepetition repetition{static_cast<int>(frames.size()), static_cast<int>(repeats.pairs.size()),
                             repeats.correlation, 0.0};
  std::vector<double> likeness(frames.size(), 1.0);
  for (const auto& [a, b] : repeats.pairs) {
    likeness[a] += repeats.correlation;
    likeness[b] += repeats.correlation;
  }
  for (const double sum : likeness) repetition.worth += 1.0 / sum;
  return repetition;
}

std::optional<Eigen::MatrixXd> repeated_errors(const CalibrationProblem& problem, const BundleState& state,
                                               const std::vector<std::string>& names, int threads) {
  std::vector<double> cell_px;
  for (const Camera& camera : state.cameras) cell_px.push_back(cell_of(camera.size));
  const std::vector<Frame> frames = frames_of(problem, state);
  const Repeats repeats = repeats_among(frames, cell_px);
  if (repeats.correlation == 0.0) return std::nullopt;
  std::vector<bool> paired(frames.size(), false);
  for (const auto& [a, b] : repeats.pairs) paired[a] = paired[b] = true;
  std::vector<std::vector<ViewData>> views(frames.size());
  for (ViewData& view : used_views(problem, state)) {
    if (paired[view.pose]) views[view.pose].push_back(std::move(view));
  }
  const Calibration calibration = calibration_of(problem, state, names);
  std::vector<Eigen::MatrixXd> rows(frames.size());
  for_each_index(frames.size(), threads, [&](std::size_t frame) {
    if (!paired[frame]) return;
    const Eigen::MatrixXd of_frame = rows_beside_pose(calibration, views[frame], state.poses[frame].rig_from_target);
    rows[frame] = of_frame.leftCols(of_frame.cols() - 1);
  });
  const auto size = static_cast<Eigen::Index>(names.size());
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(size, size);
  for (const auto& [a, b] : repeats.pairs) {
    const auto [of_a, of_b] = common_rows(frames[a], rows[a], frames[b], rows[b]);
    sum += of_a.transpose() * of_b;
  }
  return repeats.correlation * (sum + sum.transpose());
}

}  // namespace raybundle
