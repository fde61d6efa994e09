// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/bundle/information.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <map>

#include "block_information.hpp"
#include "layout.hpp"
#include "normal_equations.hpp"
#include "raybundle/bundle/view_block.hpp"
#include "raybundle/geometry/error.hpp"
#include "unknowns.hpp"

namespace raybundle {
namespace {

// Rows of everything that one board pose is seen in: the pose's six columns, and those of the free parameters and of
// the residual.
struct PoseRows {
  Eigen::MatrixXd wrt_pose = Eigen::MatrixXd(0, 6);
  Eigen::MatrixXd wrt_parameters;  // last column: residual

  void append(const ViewData& view, const ViewBlock& block, const Layout& layout) {
    const Eigen::Index before = wrt_pose.rows();
    const Eigen::Index count = block.residual.size() - 1;  // the last row has no Jacobian
    wrt_pose.conservativeResize(before + count, 6);
    wrt_parameters.conservativeResize(before + count, layout.columns + 1);
    wrt_pose.bottomRows(count) = block.wrt_rig_from_target.topRows(count);
    auto rows = wrt_parameters.bottomRows(count);
    rows.setZero();
    rows.rightCols<1>() = block.residual.head(count);
    using Kind = ParameterBlock::Kind;
    layout.scatter(Kind::kIntrinsics, view.camera, block.wrt_intrinsics.topRows(count), rows);
    layout.scatter(Kind::kCameraFromRig, view.camera, block.wrt_camera_from_rig.topRows(count), rows);
    if (block.wrt_shape.cols() > 0) layout.scatter(Kind::kShape, view.target, block.wrt_shape.topRows(count), rows);
  }

  // What is left of the rows about the parameters when the pose may follow freely: their part that is orthogonal to
  // the pose's columns. No difference of large matrices is formed, so that an unseen direction comes out as such. Fewer
  // rows by as many directions of the pose as are seen: six, but three when all points are infinitely far.
  Eigen::MatrixXd eliminated() const {
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(wrt_pose);
    Eigen::MatrixXd rotated = wrt_parameters;
    rotated.applyOnTheLeft(qr.householderQ().adjoint());
    return rotated.bottomRows(rotated.rows() - qr.rank());
  }
};

std::vector<std::string> free_names(const Layout& layout) {
  std::vector<std::string> names;
  for (const ParameterBlock& block : layout.blocks) {
    for (int i : block.free()) names.push_back(block.parameters[i].name);
  }
  return names;
}

[[noreturn]] void throw_unprojectable(const CalibrationProblem& problem, int view) {
  throw Error(ErrorKind::kSolveFailed,
              "a corner or a dot in use is not projected by the camera model; mark_projectable() and mark_dots() find "
              "such ones",
              view_name(problem, problem.views[view]));
}

// Calls visit(pose, rows) for every pose in use, in order, so that sums are formed in the same order every time. The
// rows of one pose at a time exist: those of all would be several times larger than the problem.
template <typename Visit>
void for_each_pose(const CalibrationProblem& problem, const BundleState& state, const BundleOptions& options,
                   const Layout& layout, const Visit& visit) {
  const Unknowns unknowns(state);
  std::map<int, std::vector<ViewData>> views_of_pose;
  for (ViewData& view : used_views(problem, state)) views_of_pose[view.pose].push_back(std::move(view));
  ViewBlock block;
  for (const auto& [pose, views] : views_of_pose) {
    PoseRows rows;
    for (const ViewData& view : views) {
      const ViewBlockOptions view_options{.with_shape = layout.estimates_shape(view.target),
                                          .robust_scale_sigma = options.robust_scale_sigma};
      if (!linearize_view(view, unknowns.at(view), view_options, block)) throw_unprojectable(problem, view.view);
      rows.append(view, block, layout);
    }
    visit(pose, rows);
  }
}

// The equations at the state when there are beams, with the directions that nothing sees pinned.
struct BeamSystem {
  NormalEquations equations;
  Linearization here;
  PinnedDirections pinned;

  BeamSystem(const CalibrationProblem& problem, const BundleState& state, const BundleOptions& options)
      : equations(problem, state, options) {
    if (!equations.linearize(Unknowns(state), here)) {
      const std::vector<int>& refusals = equations.refusals();
      throw_unprojectable(problem, static_cast<int>(std::ranges::max_element(refusals) - refusals.begin()));
    }
    pinned = pin_unseen(here.system);
  }
};

int rank(const Eigen::Matrix4d& information) { return static_cast<int>(information.fullPivHouseholderQr().rank()); }

ReducedInformation information_with_beams(BeamSystem& at, const BundleOptions& options) {
  NormalEquations& equations = at.equations;
  const BlockSystem& system = at.here.system;
  ReducedInformation result{.names = free_names(equations.layout()),
                            .information = parameter_information(system, equations.workers()),
                            .chi2 = system.chi2};
  for (const ViewData& view : equations.views()) result.residuals += 2 * static_cast<int>(view.pixel.rows());
  for (const ViewDots& view : equations.dots()) result.residuals += 2 * static_cast<int>(view.dots.size());
  for (const PriorResidual& prior : at.here.priors) result.residuals += static_cast<int>(prior.residual.size());
  result.parameters = system.parameters() + 6 * system.poses.blocks() - at.pinned.of_poses;
  for (std::size_t b = 0; b < at.pinned.of_beam.size(); ++b) {
    result.parameters += 4 - at.pinned.of_beam[b];
    if (options.beam_priors.empty()) continue;
    const std::optional<BeamPrior>& prior = options.beam_priors[equations.beams()[b]];
    if (prior) result.residuals += rank(prior->information);
  }
  return result;
}

}  // namespace

ReducedInformation reduced_information(const CalibrationProblem& problem, const BundleState& state,
                                       const BundleOptions& options) {
  if (!active_beams(used_dots(problem, state), state, options).empty()) {
    BeamSystem at(problem, state, options);
    return information_with_beams(at, options);
  }
  const Layout layout(estimated_blocks(problem, state, options));
  ReducedInformation result;
  result.information.setZero(layout.columns, layout.columns);
  result.parameters = layout.columns;
  result.names = free_names(layout);

  for_each_pose(problem, state, options, layout, [&](int, const PoseRows& rows) {
    result.chi2 += rows.wrt_parameters.rightCols<1>().squaredNorm();
    result.residuals += static_cast<int>(rows.wrt_parameters.rows());
    const Eigen::MatrixXd left = rows.eliminated().leftCols(layout.columns);
    result.parameters += static_cast<int>(rows.wrt_parameters.rows() - left.rows());
    result.information += left.transpose() * left;
  });

  for (const ParameterBlock& block : layout.blocks) {
    if (block.with_prior().empty()) continue;
    const PriorResidual prior = prior_residual(block, prior_mean(problem, state, block), current_values(state, block));
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(prior.residual.size(), layout.columns);
    layout.scatter(block.kind, block.owner, prior.jacobian, rows);
    result.information += rows.transpose() * rows;
    result.chi2 += prior.residual.squaredNorm();
    result.residuals += static_cast<int>(prior.residual.size());
  }
  return result;
}

std::vector<FrameInformation> information_by_frame(const CalibrationProblem& problem, const BundleState& state,
                                                   const BundleOptions& options) {
  const Layout layout(estimated_blocks(problem, state, options));
  std::map<int, FrameInformation> frames;
  for_each_pose(problem, state, options, layout, [&](int pose, const PoseRows& rows) {
    const Eigen::MatrixXd left = rows.eliminated();
    const auto parameters = left.leftCols(layout.columns);
    FrameInformation& frame = frames[state.poses[pose].frame];
    if (frame.gradient.size() == 0) {
      frame.frame = state.poses[pose].frame;
      frame.information.setZero(layout.columns, layout.columns);
      frame.gradient.setZero(layout.columns);
    }
    frame.information += parameters.transpose() * parameters;
    frame.gradient += parameters.transpose() * left.rightCols<1>();
  });
  std::vector<FrameInformation> result;
  for (auto& [index, frame] : frames) result.push_back(std::move(frame));
  return result;
}

std::vector<std::optional<BeamCovariance>> beam_covariances(const CalibrationProblem& problem, const BundleState& state,
                                                            const BundleOptions& options) {
  std::vector<std::optional<BeamCovariance>> result(state.beams.size());
  if (active_beams(used_dots(problem, state), state, options).empty()) return result;
  BeamSystem at(problem, state, options);
  const std::vector<BeamCovariance> covariances = marginal_beams(at.here.system, at.equations.workers());
  for (std::size_t b = 0; b < covariances.size(); ++b) {
    if (at.pinned.of_beam[b] == 0) result[at.equations.beams()[b]] = covariances[b];
  }
  return result;
}

}  // namespace raybundle
