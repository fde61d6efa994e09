// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "misnumbered_views.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/quantile.hpp"
#include "terminal.hpp"

namespace raybundle::apps {
namespace {

using Places = Eigen::Matrix<double, Eigen::Dynamic, 2>;  // a row for each corner

constexpr double kFlattest = 1e-3;  // of the affine map from board to image, short over long side: below, who knows
constexpr int kFewestCorners = 20;  // twice the terms of a cubic
// Of the distance to the next corner. Lenses and perspective leave a tenth of it at the most, another order more than
// all of it.
constexpr double kFarthest = 0.5;

struct Corners {
  Places on_board, in_image;
};

Corners corners_of(const Target& target, const TargetView& view) {
  Corners corners{Places(view.observations.size(), 2), Places(view.observations.size(), 2)};
  Eigen::Index count = 0;
  for (const Observation& observation : view.observations) {
    const TargetPoint* point = target.find(observation.point_id);
    if (point == nullptr) continue;
    corners.on_board.row(count) = point->x_in_target.head<2>();
    corners.in_image.row(count++) = observation.pixel;
  }
  corners.on_board.conservativeResize(count, 2);
  corners.in_image.conservativeResize(count, 2);
  return corners;
}

// 1 when the board is mapped into the image without mirroring, -1 when mirrored, 0 when that cannot be said. A lens and
// a perspective change how large parts of the board appear, never which way round their corners turn.
int handedness(const Corners& corners) {
  if (corners.on_board.rows() < 3) return 0;
  const Places from_mean = corners.on_board.rowwise() - corners.on_board.colwise().mean();
  const Eigen::Matrix2d products = corners.in_image.transpose() * from_mean;
  const double determinant = products.determinant();
  if (std::abs(determinant) <= kFlattest * products.squaredNorm()) return 0;
  return determinant > 0 ? 1 : -1;
}

// Whether the pixels are a smooth function of the places on the board, of which a cubic is enough to tell.
bool in_order(const Corners& corners) {
  const Eigen::Index count = corners.on_board.rows();
  if (count < kFewestCorners) return true;
  const Places from_mean = corners.on_board.rowwise() - corners.on_board.colwise().mean();
  const Places scaled = from_mean / from_mean.cwiseAbs().maxCoeff();
  const Eigen::ArrayXd x = scaled.col(0), y = scaled.col(1);
  Eigen::MatrixXd terms(count, 10);
  terms << Eigen::VectorXd::Ones(count), x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y;
  const Places off = corners.in_image - terms * terms.colPivHouseholderQr().solve(corners.in_image);
  std::vector<double> distances, steps;
  for (Eigen::Index i = 0; i < count; ++i) {
    distances.push_back(off.row(i).norm());
    if (i == 0) continue;
    steps.push_back((corners.in_image.row(i) - corners.in_image.row(i - 1)).norm());
  }
  return median(distances) <= kFarthest * median(steps);
}

struct Verdict {
  int hand = 0;
  bool in_order = true;
};

// Of a camera of whose views of a board most are in another order none counts, which is warned of; when there is no other
// camera, or all of them see it so, the board is not the one that was named, and is refused.
void judge_order(const CalibrationProblem& problem, std::vector<Verdict>& verdicts) {
  using CameraAndBoard = std::pair<int, int>;
  const auto of = [&](std::size_t v) { return CameraAndBoard{problem.views[v].camera, problem.views[v].target}; };
  std::map<CameraAndBoard, std::pair<int, int>> counts;  // out of order, all
  for (std::size_t v = 0; v < verdicts.size(); ++v) {
    auto& [out_of_order, all] = counts[of(v)];
    out_of_order += !verdicts[v].in_order;
    ++all;
  }
  const auto wrong = [](const auto& entry) { return 2 * entry.second.first > entry.second.second; };
  const bool refused = std::ranges::all_of(counts, wrong);
  for (const auto& entry : counts) {
    if (!wrong(entry)) continue;
    const auto& [which, count] = entry;
    const std::string message = fmt::format(
        "camera {}: in {} of {} views the corners do not lie in the order of {}: are its rows and columns "
        "exchanged, or is it another board?",
        problem.cameras[which.first].name, count.first, count.second, problem.targets[which.second].name);
    if (refused) throw Error(ErrorKind::kBadInput, message);
    say_warning(message + " These views are left out");
  }
  for (std::size_t v = 0; v < verdicts.size(); ++v) {
    if (wrong(*counts.find(of(v)))) verdicts[v].in_order = false;
  }
}

}  // namespace

void leave_out_misnumbered_views(DetectedImages& images) {
  CalibrationProblem& problem = images.observations.problem;
  std::vector<Verdict> verdicts;
  std::map<std::pair<int, int>, int> balance;  // of hands, by camera and board
  for (const TargetView& view : problem.views) {
    const Target& target = problem.targets[view.target];
    Verdict& verdict = verdicts.emplace_back();
    if (!target.flat()) continue;
    const Corners corners = corners_of(target, view);
    verdict.in_order = in_order(corners);
    verdict.hand = verdict.in_order ? handedness(corners) : 0;
    balance[{view.camera, view.target}] += verdict.hand;
  }
  judge_order(problem, verdicts);
  std::vector<TargetView> kept;
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    TargetView& view = problem.views[v];
    const int usual = balance[{view.camera, view.target}] >= 0 ? 1 : -1;
    if (verdicts[v].in_order && verdicts[v].hand != -usual) {
      kept.push_back(std::move(view));
      continue;
    }
    // Without its file, the image is not looked at again for corners that a first solve predicts.
    std::erase_if(images.files, [&](const ImageFile& file) { return !file.video && file.path == view.image; });
    const std::string image = view.image.empty() ? view_name(problem, view) : view.image;
    const char* reason = verdicts[v].in_order
                             ? "its corners are in mirror order compared with the other views: a mirrored image, u and "
                               "v swapped, or another numbering of the board"
                             : "its corners do not lie in the order of the board: another board, or another numbering";
    images.unused.push_back({problem.cameras[view.camera].name, problem.frames[view.frame], image, reason});
  }
  problem.views = std::move(kept);
}

void warn_of_mirrored_views(const Board& board, const CalibrationProblem& problem) {
  if (std::holds_alternative<PointSet>(board)) return;                       // whose z may point anywhere
  const int from_front = std::holds_alternative<AprilGrid>(board) ? -1 : 1;  // Kalibr's y runs up the board
  std::map<int, std::pair<int, int>> counts;                                 // by camera: from behind, of all
  for (const TargetView& view : problem.views) {
    const int hand = handedness(corners_of(problem.targets[view.target], view));
    auto& [behind, all] = counts[view.camera];
    behind += hand == -from_front;
    all += hand != 0;
  }
  for (const auto& [camera, count] : counts) {
    const auto& [behind, all] = count;
    if (2 * behind <= all) continue;
    say_warning(fmt::format(
        "camera {}: in {} of {} views the corners lie as on a board that is seen from behind: does v count "
        "upwards, or is the image mirrored? Then what is told of the camera is mirrored, too. Where only the "
        "board's points are numbered the other way round, all is well",
        problem.cameras[camera].name, behind, all));
  }
}

}  // namespace raybundle::apps
