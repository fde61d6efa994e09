// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/initialize/rig_start.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "board_agreement.hpp"
#include "lens_bundle.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

using Pairs = std::vector<std::pair<const PosedView*, const PosedView*>>;

/// Relative poses of all pairs of cameras that share a board, by (a, b), a < b.
std::map<std::pair<int, int>, PairConsensus> all_pairs(const std::vector<SharedBoard>& boards) {
  std::map<std::pair<int, int>, Pairs> pairs;
  for (const SharedBoard& board : boards) {
    for (std::size_t i = 0; i < board.views.size(); ++i) {
      for (std::size_t j = i + 1; j < board.views.size(); ++j) {
        pairs[{board.views[i].camera, board.views[j].camera}].emplace_back(&board.views[i], &board.views[j]);
      }
    }
  }
  std::map<std::pair<int, int>, PairConsensus> consensus;
  for (const auto& [cameras, views] : pairs) consensus[cameras] = pair_consensus(views);
  return consensus;
}

/// Places the cameras one after another, each by the strongest tie to those that have a place (Prim).
std::vector<Rigid3> place_cameras(const CalibrationProblem& problem,
                                  const std::map<std::pair<int, int>, PairConsensus>& pairs) {
  std::vector<std::optional<Rigid3>> camera_from_rig(problem.cameras.size());
  camera_from_rig[0] = Rigid3{};
  for (std::size_t c = 1; c < problem.cameras.size(); ++c) camera_from_rig[c] = problem.cameras[c].camera_from_rig;
  while (true) {
    int strongest = 0;
    int placed = -1;
    Rigid3 place;
    for (const auto& [cameras, tie] : pairs) {
      const auto [a, b] = cameras;
      if (camera_from_rig[a].has_value() == camera_from_rig[b].has_value() || tie.agreeing <= strongest) continue;
      strongest = tie.agreeing;
      placed = camera_from_rig[a] ? b : a;
      place = camera_from_rig[a] ? tie.b_from_a * *camera_from_rig[a] : tie.b_from_a.inverse() * *camera_from_rig[b];
    }
    if (placed < 0) break;
    camera_from_rig[placed] = place;
  }

  std::vector<Rigid3> result;
  std::string missing;
  for (std::size_t c = 0; c < camera_from_rig.size(); ++c) {
    if (camera_from_rig[c]) {
      result.push_back(*camera_from_rig[c]);
    } else {
      missing += (missing.empty() ? "" : ", ") + problem.cameras[c].name;
    }
  }
  if (!missing.empty()) {
    throw Error(ErrorKind::kNotEnoughData, "no chain of frames in which two cameras see the same board links " +
                                               missing + " to " + problem.cameras[0].name +
                                               "; add images in which they see the board at the same moment");
  }
  return result;
}

/// How well the views of a board fit together when one of them is taken at its word.
struct Opinion {
  std::size_t reference = 0;
  int reference_pose = 0;              ///< of its candidates
  std::vector<Disagreement> of_views;  ///< aligned with the board's views
  int agreeing = 0;                    ///< the reference included

  double size() const {
    double sum = 0.0;
    for (const Disagreement& of_view : of_views) sum += of_view.size;
    return sum;
  }
};

Opinion opinion_of(const SharedBoard& board, std::size_t reference, int reference_pose,
                   const std::vector<Rigid3>& camera_from_rig, double limit) {
  Opinion opinion;
  opinion.reference = reference;
  opinion.reference_pose = reference_pose;
  const PosedView& a = board.views[reference];
  for (const PosedView& b : board.views) {
    const Rigid3 b_from_a = camera_from_rig[b.camera] * camera_from_rig[a.camera].inverse();
    opinion.of_views.push_back(&a == &b ? Disagreement{} : disagreement(a, reference_pose, b, b_from_a));
    opinion.agreeing += opinion.of_views.back().size <= limit;
  }
  return opinion;
}

/// A larger party wins; among equals the view that fixes the board best, then its own first choice if it is no worse.
bool better(const SharedBoard& board, const Opinion& opinion, const Opinion& best) {
  if (opinion.agreeing != best.agreeing) return opinion.agreeing > best.agreeing;
  if (opinion.reference != best.reference) {
    return board.views[opinion.reference].looseness() < board.views[best.reference].looseness();
  }
  return opinion.size() < best.size();
}

/// The view that most of the others agree with.
Opinion best_opinion(const SharedBoard& board, const std::vector<Rigid3>& camera_from_rig, double limit) {
  std::optional<Opinion> best;
  for (std::size_t r = 0; r < board.views.size(); ++r) {
    for (int pose = 0; pose < board.views[r].as_labelled; ++pose) {
      Opinion opinion = opinion_of(board, r, pose, camera_from_rig, limit);
      if (!best || better(board, opinion, *best)) best = std::move(opinion);
    }
  }
  return *best;
}

/// Spread of the views' disagreement with the best view of their board, over all boards.
double common_spread(const std::vector<SharedBoard>& boards, const std::vector<Rigid3>& camera_from_rig) {
  std::vector<double> sizes;
  for (const SharedBoard& board : boards) {
    if (board.views.size() < 2) continue;
    const Opinion opinion = best_opinion(board, camera_from_rig, 0.0);
    for (std::size_t i = 0; i < board.views.size(); ++i) {
      if (i != opinion.reference) sizes.push_back(opinion.of_views[i].size);
    }
  }
  return sizes.empty() ? 0.0 : quantile(sizes, kQuorum);
}

}  // namespace

RigStart initialize_rig(const CalibrationProblem& problem, const std::vector<std::optional<Rigid3>>& camera_from_target,
                        const std::vector<std::optional<Rigid3>>& mirrored) {
  const std::vector<SharedBoard> boards = shared_boards(problem, camera_from_target, mirrored);
  RigStart start;
  start.camera_from_rig = place_cameras(problem, all_pairs(boards));
  start.pose_of_view.assign(problem.views.size(), -1);
  start.symmetry_of_view.assign(problem.views.size(), -1);

  const double limit = agreement_limit(common_spread(boards, start.camera_from_rig));
  const auto add_pose = [&](const SharedBoard& board, const PosedView& view, int candidate) {
    const Rigid3& camera_from_target_of_view = view.camera_from_target[candidate];
    start.pose_of_view[view.view] = static_cast<int>(start.poses.size());
    start.poses.push_back(
        {board.frame, board.target, start.camera_from_rig[view.camera].inverse() * camera_from_target_of_view});
  };
  for (const SharedBoard& board : boards) {
    const Opinion opinion = best_opinion(board, start.camera_from_rig, limit);
    const PosedView& reference = board.views[opinion.reference];
    add_pose(board, reference, opinion.agreeing > 1 ? opinion.reference_pose : 0);
    const int shared = start.pose_of_view[reference.view];
    for (std::size_t i = 0; i < board.views.size(); ++i) {
      if (i == opinion.reference) continue;
      const PosedView& view = board.views[i];
      const Disagreement& d = opinion.of_views[i];
      if (d.size <= limit) {
        start.pose_of_view[view.view] = shared;
        start.symmetry_of_view[view.view] = view.symmetry[d.candidate];
      } else {
        add_pose(board, view, 0);
      }
    }
  }
  return start;
}

}  // namespace raybundle
