// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "board_agreement.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "lens_bundle.hpp"
#include "linear_pose.hpp"
#include "raybundle/geometry/rotation.hpp"

namespace raybundle {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr std::size_t kMaxHypotheses = 60;
constexpr int kRounds = 8;  // of least squares, while frames come and go

/// Rigid motion of the board that takes each point to its image under a symmetry.
Rigid3 motion_of(const Target& target, const TargetSymmetry& symmetry) {
  const double count = static_cast<double>(target.points.size());
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector3d image_centre = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < target.points.size(); ++i) {
    centre += target.points[i].x_in_target / count;
    image_centre += target.find(symmetry.ids[i])->x_in_target / count;
  }
  Eigen::Matrix3d correlation = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < target.points.size(); ++i) {
    correlation += (target.find(symmetry.ids[i])->x_in_target - image_centre) *
                   (target.points[i].x_in_target - centre).transpose();
  }
  const Eigen::Matrix3d rotation = nearest_rotation(correlation);
  return {Eigen::Quaterniond(rotation), image_centre - rotation * centre};
}

/// PosedView::covariance of a view as labelled.
Matrix6 covariance_of(const Target& target, const TargetView& view, const Rigid3& camera_from_target,
                      const Eigen::Vector3d& centre_in_target) {
  const Eigen::Matrix3d rotation = camera_from_target.rotation.toRotationMatrix();
  Matrix6 information = Matrix6::Zero();
  for (const Observation& observation : view.observations) {
    const TargetPoint* point = target.find(observation.point_id);
    if (!point) continue;
    const Eigen::Vector3d x = camera_from_target * point->x_in_target;
    const Eigen::Vector3d direction = x.normalized();
    Eigen::Matrix<double, 3, 6> jacobian;
    jacobian.leftCols<3>() = -rotation * skew(point->x_in_target - centre_in_target);
    jacobian.rightCols<3>() = rotation;
    jacobian = ((jacobian - direction * (direction.transpose() * jacobian)) / x.norm()).eval();
    information += jacobian.transpose() * jacobian;
  }
  const Vector6 scale = information.diagonal().cwiseMax(1e-30).cwiseSqrt().cwiseInverse();
  Matrix6 scaled = scale.asDiagonal() * information * scale.asDiagonal();
  scaled.diagonal().array() += 1e-9;  // corners on one line leave a turn about it open
  return scale.asDiagonal() * scaled.ldlt().solve(Matrix6::Identity()) * scale.asDiagonal();
}

/// @param shared  whether other views saw the board; covariances are for what they disagree about
PosedView posed_view(const CalibrationProblem& problem, int index, const Rigid3& pose,
                     const std::optional<Rigid3>& mirrored, bool shared) {
  const TargetView& view = problem.views[index];
  const Target& target = problem.targets[view.target];
  PosedView posed;
  posed.view = index;
  posed.camera = view.camera;
  std::vector<Rigid3> as_labelled{pose};
  if (mirrored) as_labelled.push_back(*mirrored);
  posed.as_labelled = static_cast<int>(as_labelled.size());
  std::vector<Eigen::Vector3d> points;
  for (const TargetPoint& point : target.points) points.push_back(point.x_in_target);
  posed.centre_in_target = principal_frame(points).centre;

  for (int symmetry = -1; symmetry < static_cast<int>(target.symmetries.size()); ++symmetry) {
    const Rigid3 motion = symmetry < 0 ? Rigid3{} : motion_of(target, target.symmetries[symmetry]);
    Matrix6 turn = Matrix6::Zero();
    turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = motion.rotation.toRotationMatrix();
    for (const Rigid3& candidate : as_labelled) {
      posed.camera_from_target.push_back(candidate * motion.inverse());
      posed.symmetry.push_back(symmetry);
      if (!shared) continue;
      const Matrix6 covariance = covariance_of(target, view, candidate, posed.centre_in_target);
      posed.covariance.push_back(turn * covariance * turn.transpose());
    }
  }
  return posed;
}

std::vector<Rigid3> relative_poses(const PosedView& a, const PosedView& b) {
  std::vector<Rigid3> b_from_a;
  for (int k = 0; k < a.as_labelled; ++k) {
    for (const Rigid3& b_from_target : b.camera_from_target) {
      b_from_a.push_back(b_from_target * a.camera_from_target[k].inverse());
    }
  }
  return b_from_a;
}

using Pairs = std::vector<std::pair<const PosedView*, const PosedView*>>;

/// Disagreement of the candidates of both views that agree best.
struct PairDisagreement {
  Disagreement of_b;
  int a_candidate = 0;
};

PairDisagreement pair_disagreement(const PosedView& a, const PosedView& b, const Rigid3& b_from_a) {
  PairDisagreement best{disagreement(a, 0, b, b_from_a)};
  for (int k = 1; k < a.as_labelled; ++k) {
    const Disagreement d = disagreement(a, k, b, b_from_a);
    if (d.size < best.of_b.size) best = {d, k};
  }
  return best;
}

std::vector<double> sizes(const Pairs& pairs, const Rigid3& b_from_a) {
  std::vector<double> result;
  for (const auto& [a, b] : pairs) result.push_back(pair_disagreement(*a, *b, b_from_a).of_b.size);
  return result;
}

/// Size that a quorum of the frames stays below. A frame always agrees with the pose that it proposes itself, so that
/// at least one more must.
double quorum_size(std::vector<double>& sizes) {
  const double one_more = 1.0 / std::max(1.0, static_cast<double>(sizes.size()) - 1.0);
  return quantile(sizes, std::max(kQuorum, one_more));
}

/// Motion of the board, in its own frame at its centre, from where `b` has it to where `expected` has it.
Vector6 motion_in_board(const PosedView& b, int candidate, const Rigid3& expected) {
  const Rigid3& seen = b.camera_from_target[candidate];
  Vector6 motion;
  motion.head<3>() = vector_from_rotation((seen.rotation.conjugate() * expected.rotation).toRotationMatrix());
  motion.tail<3>() = seen.rotation.conjugate() * (expected * b.centre_in_target - seen * b.centre_in_target);
  return motion;
}

/// Least squares over the frames within the limit, one Gauss-Newton step from a pose near by.
Rigid3 improved_pose(const Pairs& pairs, const Rigid3& b_from_a, double limit) {
  Matrix6 normal = Matrix6::Zero();
  Vector6 right = Vector6::Zero();
  for (const auto& [a, b] : pairs) {
    const auto [d, a_candidate] = pair_disagreement(*a, *b, b_from_a);
    if (!(d.size <= limit)) continue;
    const Rigid3 expected = b_from_a * a->camera_from_target[a_candidate];
    const Eigen::Matrix3d board_from_camera =
        b->camera_from_target[d.candidate].rotation.conjugate().toRotationMatrix();
    // perturbed(b_from_a, (w, v)) moves the board's centre by v and by w across its arm from the translation.
    const Eigen::Vector3d arm = expected * b->centre_in_target - b_from_a.translation;
    Matrix6 jacobian = Matrix6::Zero();
    jacobian.topLeftCorner<3, 3>() = board_from_camera;
    jacobian.bottomLeftCorner<3, 3>() = -board_from_camera * skew(arm);
    jacobian.bottomRightCorner<3, 3>() = board_from_camera;
    const Matrix6 weighted = (a->covariance[a_candidate] + b->covariance[d.candidate]).ldlt().solve(jacobian);
    normal += jacobian.transpose() * weighted;
    right -= weighted.transpose() * motion_in_board(*b, d.candidate, expected);
  }
  const Vector6 step = normal.ldlt().solve(right);
  return step.allFinite() ? perturbed(b_from_a, step) : b_from_a;
}

}  // namespace

std::vector<SharedBoard> shared_boards(const CalibrationProblem& problem,
                                       const std::vector<std::optional<Rigid3>>& camera_from_target,
                                       const std::vector<std::optional<Rigid3>>& mirrored) {
  std::map<std::pair<int, int>, std::vector<int>> views_of_board;  // by frame and target
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    if (!camera_from_target[v]) continue;
    const TargetView& view = problem.views[v];
    views_of_board[{view.frame, view.target}].push_back(static_cast<int>(v));
  }
  std::vector<SharedBoard> boards;
  for (const auto& [key, views] : views_of_board) {
    SharedBoard& board = boards.emplace_back();
    std::tie(board.frame, board.target) = key;
    for (const int v : views) {
      const std::optional<Rigid3> other_pose = mirrored.empty() ? std::nullopt : mirrored[v];
      board.views.push_back(posed_view(problem, v, *camera_from_target[v], other_pose, views.size() > 1));
    }
    std::ranges::stable_sort(board.views, {}, &PosedView::camera);
  }
  return boards;
}

Disagreement disagreement(const PosedView& a, int a_candidate, const PosedView& b, const Rigid3& b_from_a) {
  const Rigid3 expected = b_from_a * a.camera_from_target[a_candidate];
  Disagreement best;
  best.size = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < b.camera_from_target.size(); ++k) {
    Disagreement d;
    d.candidate = static_cast<int>(k);
    const Vector6 motion = motion_in_board(b, d.candidate, expected);
    const Matrix6 covariance = a.covariance[a_candidate] + b.covariance[k];
    d.size = std::sqrt(std::max(0.0, motion.dot(covariance.ldlt().solve(motion))) / 6.0);
    if (d.size < best.size) best = d;
  }
  return best;
}

PairConsensus pair_consensus(const Pairs& pairs) {
  PairConsensus consensus;
  double best = std::numeric_limits<double>::infinity();
  const std::size_t stride = (pairs.size() + kMaxHypotheses - 1) / kMaxHypotheses;
  for (std::size_t i = 0; i < pairs.size(); i += stride) {
    const auto& [a, b] = pairs[i];
    for (const Rigid3& hypothesis : relative_poses(*a, *b)) {
      std::vector<double> errors = sizes(pairs, hypothesis);
      const double spread = quorum_size(errors);
      if (!(spread < best)) continue;
      best = spread;
      consensus.b_from_a = hypothesis;
    }
  }
  for (int round = 0; round <= kRounds; ++round) {
    std::vector<double> errors = sizes(pairs, consensus.b_from_a);
    consensus.spread = quorum_size(errors);
    if (round < kRounds) {
      consensus.b_from_a = improved_pose(pairs, consensus.b_from_a, 0.5 * agreement_limit(consensus.spread));
    }
  }
  for (const double size : sizes(pairs, consensus.b_from_a)) {
    consensus.agreeing += size <= agreement_limit(consensus.spread);
  }
  return consensus;
}

double agreement_limit(double spread) {
  constexpr double kNoise_rad = 2e-5;  // a fiftieth of a pixel: exact data has no spread to measure by
  return 5.0 * std::max(spread, kNoise_rad);
}

}  // namespace raybundle
