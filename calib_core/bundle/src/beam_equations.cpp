// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// What NormalEquations does when there are beams: the equations of poses, beams and parameters as one BlockSystem.
#include <Eigen/Cholesky>
#include <algorithm>
#include <atomic>
#include <map>

#include "normal_equations.hpp"
#include "raybundle/geometry/gram.hpp"

namespace raybundle {
namespace {

constexpr int kMostChunks = 16;       // of poses whose sums over the beams are formed apart
constexpr double kBytesForDot = 100;  // that these sums may take

int chunk_count(std::size_t poses, std::size_t pairs, std::size_t beams, int parameters) {
  const double chunk_bytes = 32.0 * static_cast<double>(beams) * (parameters + 5);
  const double affordable = kBytesForDot * static_cast<double>(pairs) / chunk_bytes;
  const int chunks = static_cast<int>(std::clamp(affordable, 2.0, 1.0 * kMostChunks));
  return std::min(chunks, static_cast<int>(poses));
}

// Offsets and slopes: the second act like the first, but at a distance.
Eigen::Vector4d at_distance(const Eigen::Vector2d& by_offset, double distance) {
  return {by_offset[0], by_offset[1], distance * by_offset[0], distance * by_offset[1]};
}

}  // namespace

// What a chunk of poses adds up, and where it works.
struct NormalEquations::DotPart {
  BlockSystem::Shared shared;
  DotRows rows;
  Eigen::MatrixXd products, local;
  double robust_chi2 = 0.0, weighted_chi2 = 0.0;
};

void NormalEquations::number_beams(const BundleState& state, const BundleOptions& options) {
  beams_ = active_beams(dots_, state, options);
  if (beams_.empty()) return;
  number_of_beam_.assign(state.beams.size(), -1);
  for (std::size_t b = 0; b < beams_.size(); ++b) number_of_beam_[beams_[b]] = static_cast<int>(b);
  pattern_.poses = BlockFamily<6>(static_cast<int>(poses_.size()), layout_.columns);
  pattern_.shared = BlockSystem::Shared(layout_.columns, static_cast<int>(beams_.size()));
  for (std::size_t p = 0; p < poses_.size(); ++p) {
    std::map<int, int> number_of_pair;
    for (int v : poses_[p].dots) {
      for (const UsedDot& dot : dots_[v].dots) number_of_pair[number_of_beam_[dot.beam]] = 0;
    }
    for (auto& [beam, number] : number_of_pair) {
      number = static_cast<int>(pattern_.pose_beams.size());
      pattern_.pose_beams.push_back({.pose = static_cast<int>(p), .beam = beam});
    }
    for (int v : poses_[p].dots) {
      for (UsedDot& dot : dots_[v].dots) dot.pose_beam = number_of_pair[number_of_beam_[dot.beam]];
    }
  }
  if (Elimination<4, 6>::cost(pattern_) < Elimination<6, 4>::cost(pattern_)) {
    beams_first_.emplace(pattern_);
  } else {
    poses_first_.emplace(pattern_);
  }
}

void NormalEquations::add_dot(const DotMotion& motion, const UsedDot& dot,
                              const Eigen::Matrix<double, 2, Eigen::Dynamic>& rows, const std::vector<int>& columns,
                              DotPart& part, BlockSystem& system) const {
  BlockFamily<4>& beams = part.shared.beams;
  const int beam = number_of_beam_[dot.beam];
  const double distance = motion.distance;
  const Eigen::Matrix2d square = motion.across.transpose() * motion.across;
  auto own = beams.own.middleCols<4>(4 * beam);
  own.topLeftCorner<2, 2>() += square;
  own.topRightCorner<2, 2>() += distance * square;
  own.bottomLeftCorner<2, 2>() += distance * square;
  own.bottomRightCorner<2, 2>() += distance * distance * square;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    if (columns[c] < 0) continue;
    const Eigen::Vector2d product = motion.across.transpose() * rows.col(static_cast<Eigen::Index>(c));
    beams.with_parameters.col(static_cast<Eigen::Index>(beam) * layout_.columns + columns[c]) +=
        at_distance(product, distance);
  }
  PoseBeamBlock& pair = system.pose_beams[dot.pose_beam];
  pair.by_pose = motion.by_board;
  pair.by_beam += at_distance(motion.across.transpose() * motion.along_beam, distance);
}

bool NormalEquations::add_dots(const PoseViews& group, const Unknowns& unknowns, DotPart& part, BlockSystem& system) {
  for (int v : group.dots) {
    const ViewDots& view = dots_[v];
    const DotRowsOptions options{.with_shape = layout_.estimates_shape(view.target),
                                 .with_camera = view.camera != 0,
                                 .robust_scale_sigma = robust_scale_sigma_};
    if (!fill_dot_rows(view, unknowns.at(view.camera, view.pose, view.target), unknowns.beams, options, part.rows)) {
      ++refusals_[view.view];
      return false;
    }
    part.robust_chi2 += part.rows.robust_chi2;
    gram(part.rows.rows, part.products);
    add_products(part.products, dot_columns_[v], part.local);
    const std::vector<int> columns = columns_of(view.camera, view.target);
    const int residual = part.rows.residual_column(options.with_shape);
    Eigen::Matrix<double, 2, Eigen::Dynamic> rows;
    for (std::size_t i = 0; i < view.dots.size(); ++i) {
      const UsedDot& dot = view.dots[i];
      const DotMotion& motion = part.rows.motions[i];
      rows = part.rows.rows.middleRows<2>(static_cast<Eigen::Index>(2 * i));
      add_dot(motion, dot, rows, columns, part, system);
      part.shared.beams.gradient.col(number_of_beam_[dot.beam]) +=
          at_distance(motion.across.transpose() * rows.col(residual), motion.distance);
    }
  }
  return true;
}

double NormalEquations::assemble(const Unknowns& unknowns, Linearization& result, bool& projectable) {
  BlockSystem& system = result.system;
  system = pattern_;
  const int poses = static_cast<int>(poses_.size());
  const int chunks = chunk_count(poses_.size(), pattern_.pose_beams.size(), beams_.size(), layout_.columns);
  if (!projectable) return 0.0;
  std::vector<DotPart> parts(chunks);
  std::atomic<bool> complete = true;
  workers_.for_each(chunks, [&](int c) {
    DotPart& part = parts[c];
    part.shared = pattern_.shared;
    for (int p = poses * c / chunks; p < poses * (c + 1) / chunks; ++p) {
      const PoseViews& group = poses_[p];
      fill_local_equations(group, unknowns, result, part.local);
      if (!add_dots(group, unknowns, part, system)) complete = false;
      const auto count = static_cast<Eigen::Index>(group.columns.size());
      part.weighted_chi2 += part.local(6 + count, 6 + count);
      system.poses.own.middleCols<6>(6 * p) = part.local.topLeftCorner<6, 6>().selfadjointView<Eigen::Upper>();
      system.poses.gradient.col(p) = part.local.block<6, 1>(0, 6 + count);
      for (Eigen::Index b = 0; b < count; ++b) {
        const int column = group.columns[b];
        system.poses.with_parameters.col(static_cast<Eigen::Index>(p) * layout_.columns + column) =
            part.local.block<6, 1>(0, 6 + b);
        for (Eigen::Index a = 0; a <= b; ++a) part.shared.matrix(group.columns[a], column) += part.local(6 + a, 6 + b);
        part.shared.gradient[column] += part.local(6 + b, 6 + count);
      }
    }
  });
  projectable = complete;
  double chi2 = 0.0;
  for (const DotPart& part : parts) {
    system.shared += part.shared;
    system.chi2 += part.weighted_chi2;
    chi2 += part.robust_chi2;
  }
  return chi2 + add_priors(unknowns, result.priors, system);
}

// Squared whitened distance of the beams from their priors; that of the others counts elsewhere.
double NormalEquations::add_priors(const Unknowns& unknowns, const std::vector<PriorResidual>& priors,
                                   BlockSystem& system) const {
  for (std::size_t b = 0; b < layout_.blocks.size(); ++b) {
    if (priors[b].residual.size() == 0) continue;
    const Eigen::MatrixXd rows = prior_rows(layout_, layout_.blocks[b], priors[b]);
    system.shared.matrix += rows.transpose() * rows;
    system.shared.gradient += rows.transpose() * priors[b].residual;
    system.chi2 += priors[b].residual.squaredNorm();
  }
  double chi2 = 0.0;
  for (std::size_t b = 0; b < beams_.size() && !beam_priors_.empty(); ++b) {
    if (!beam_priors_[beams_[b]]) continue;
    const BeamPriorTerm term = beam_prior_term(*beam_priors_[beams_[b]], unknowns.beams[beams_[b]]);
    const auto number = static_cast<Eigen::Index>(b);
    system.shared.beams.own.middleCols<4>(4 * number) += term.matrix;
    system.shared.beams.gradient.col(number) += term.gradient;
    chi2 += term.chi2;
  }
  system.chi2 += chi2;
  return chi2;
}

std::optional<Step> NormalEquations::step_with_beams(const Unknowns& unknowns, const Linearization& at, double radius) {
  std::optional<BlockStep> solved;
  const auto solve = [&](auto& elimination) {
    if (elimination.reduce(at.system, radius, workers_) && elimination.factor(elimination.kept(), workers_)) {
      solved = elimination.step(at.system);
    }
  };
  if (beams_first_) solve(*beams_first_);
  if (poses_first_) solve(*poses_first_);
  if (!solved) return {};
  Step step;
  step.parameters = solved->parameters;
  step.beams = solved->beams;
  step.motions.assign(unknowns.rig_from_target.size(), Eigen::Matrix<double, 6, 1>::Zero());
  for (std::size_t p = 0; p < poses_.size(); ++p) {
    step.motions[poses_[p].pose] = solved->poses.col(static_cast<Eigen::Index>(p));
  }
  step.predicted_decrease = solved->predicted_decrease;
  return step;
}

}  // namespace raybundle
