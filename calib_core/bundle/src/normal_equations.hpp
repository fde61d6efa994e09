// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "layout.hpp"
#include "unknowns.hpp"
#include "view_normal.hpp"
#include "workers.hpp"

namespace raybundle {

/// What one evaluation of the bundle keeps.
struct Linearization {
  std::vector<ViewNormal> views;      ///< of the used views
  std::vector<PriorResidual> priors;  ///< of the layout's blocks
  double cost = 0.0;
};

/// A damped Gauss-Newton step.
struct Step {
  Eigen::VectorXd parameters;                        ///< by the columns of the layout
  std::vector<Eigen::Matrix<double, 6, 1>> motions;  ///< of each pose of the state, as perturbed()
  double predicted_decrease = 0.0;                   ///< of the cost, by the undamped quadratic model
};

/// The bundle as a least-squares problem: evaluates it, and solves its damped normal equations with the board poses
/// eliminated (Schur complement). Sums are formed in an order that does not depend on the number of threads.
class NormalEquations {
 public:
  NormalEquations(const CalibrationProblem& problem, const BundleState& state, const BundleOptions& options);

  const std::vector<ViewData>& views() const { return views_; }

  /// False when some view has a corner that its camera model does not project; see refusals().
  bool linearize(const Unknowns& unknowns, Linearization& result);

  /// Nothing when the damped equations are not positive definite.
  ///
  /// @param radius  of the trust region: the diagonal is raised by its 1 / radius
  std::optional<Step> step(const Unknowns& unknowns, const Linearization& at, double radius);

  Unknowns moved(const Unknowns& unknowns, const Step& step) const;

  /// Views that were not projectable, with how often.
  const std::vector<int>& refusals() const { return refusals_; }

 private:
  // A board pose and what sees it. Its local equations have the columns: motion of the pose, `columns`, residual.
  struct PoseViews {
    int pose = 0;
    std::vector<int> views;    // indices into views_
    std::vector<int> columns;  // of the layout, on which these views depend, ascending
  };
  struct EliminatedPose;
  struct Reduced;

  void group_by_pose(std::size_t poses);
  Eigen::MatrixXd local_equations(const PoseViews& group, const Unknowns& unknowns, const Linearization& at) const;
  bool eliminate(const PoseViews& group, double radius, Eigen::MatrixXd& local, EliminatedPose& pose,
                 Reduced& reduced) const;
  void add_priors(const Linearization& at, Reduced& reduced) const;

  Layout layout_;
  std::vector<PriorMean> prior_means_;  // of the layout's blocks
  std::vector<ViewData> views_;
  std::vector<ViewBlockOptions> view_options_;
  std::vector<std::vector<int>> local_columns_;  // of each view's expanded() columns, -1: not free
  std::vector<PoseViews> poses_;
  std::vector<int> refusals_;
  Workers workers_;
};

}  // namespace raybundle
