// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "beams.hpp"
#include "block_system.hpp"
#include "elimination.hpp"
#include "layout.hpp"
#include "unknowns.hpp"
#include "view_normal.hpp"
#include "workers.hpp"

namespace raybundle {

/// What one evaluation of the bundle keeps.
struct Linearization {
  std::vector<ViewNormal> views;      ///< of the used views
  std::vector<PriorResidual> priors;  ///< of the layout's blocks
  BlockSystem system;                 ///< of everything above and the dots, when there are beams
  double cost = 0.0;
};

/// Adds the upper triangle of a view's products to that of equations in which they have other columns; -1: none.
void add_products(const Eigen::MatrixXd& products, const std::vector<int>& columns, Eigen::MatrixXd& local);

/// A damped Gauss-Newton step.
struct Step {
  Eigen::VectorXd parameters;                        ///< by the columns of the layout
  std::vector<Eigen::Matrix<double, 6, 1>> motions;  ///< of each pose of the state, as perturbed()
  Eigen::Matrix4Xd beams;                            ///< motions of the beams that take part, as perturbed()
  double predicted_decrease = 0.0;                   ///< of the cost, by the undamped quadratic model
};

/// The bundle as a least-squares problem: evaluates it, and solves its damped normal equations with the board poses
/// eliminated (Schur complement) or, when there are beams, whichever of poses and beams is cheaper to eliminate. Sums
/// are formed in an order that does not depend on the number of threads.
class NormalEquations {
 public:
  NormalEquations(const CalibrationProblem& problem, const BundleState& state, const BundleOptions& options);

  bool empty() const { return views_.empty() && dots_.empty(); }
  std::size_t residuals() const;  ///< of corners and dots
  const Layout& layout() const { return layout_; }
  const std::vector<int>& beams() const { return beams_; }  ///< of the state, that take part
  const std::vector<ViewData>& views() const { return views_; }
  const std::vector<ViewDots>& dots() const { return dots_; }

  /// False when some view has a corner or a dot that its camera model does not project, or a dot whose beam misses the
  /// board; see refusals().
  bool linearize(const Unknowns& unknowns, Linearization& result);

  /// Half the sum of ρ over everything, as linearize() has it; nothing where that is false.
  std::optional<double> cost(const Unknowns& unknowns);

  /// Nothing when the damped equations are not positive definite.
  ///
  /// @param radius  of the trust region: the diagonal is raised by its 1 / radius
  std::optional<Step> step(const Unknowns& unknowns, const Linearization& at, double radius);

  Workers& workers() { return workers_; }

  Unknowns moved(const Unknowns& unknowns, const Step& step);

  /// How often each view of the problem was not projectable.
  const std::vector<int>& refusals() const { return refusals_; }

 private:
  // A board pose and what sees it. Its local equations have the columns: motion of the pose, `columns`, residual.
  struct PoseViews {
    int pose = 0;
    std::vector<int> views;    // indices into views_
    std::vector<int> dots;     // indices into dots_
    std::vector<int> columns;  // of the layout, on which these views depend, ascending
  };
  struct EliminatedPose;
  struct Reduced;
  struct DotPart;

  void group_by_pose(std::size_t poses);
  std::vector<PriorResidual> prior_residuals(const Unknowns& unknowns) const;
  std::vector<int> columns_of(int camera, int target, bool lens_fixed = false) const;
  std::vector<int> local_columns(const PoseViews& group, int camera, int target, bool lens_fixed = false) const;
  void fill_local_equations(const PoseViews& group, const Unknowns& unknowns, const Linearization& at,
                            Eigen::MatrixXd& local) const;
  bool eliminate(const PoseViews& group, double radius, Eigen::MatrixXd& local, EliminatedPose& pose,
                 Reduced& reduced) const;
  void add_priors(const Linearization& at, Reduced& reduced) const;

  // With beams.
  void number_beams(const BundleState& state, const BundleOptions& options);
  double assemble(const Unknowns& unknowns, Linearization& result, bool& projectable);
  bool add_dots(const PoseViews& group, const Unknowns& unknowns, DotPart& part, BlockSystem& system);
  void add_dot(const DotMotion& motion, const UsedDot& dot, const Eigen::Matrix<double, 2, Eigen::Dynamic>& rows,
               const std::vector<int>& columns, DotPart& part, BlockSystem& system) const;
  double add_priors(const Unknowns& unknowns, const std::vector<PriorResidual>& priors, BlockSystem& system) const;
  std::optional<Step> step_with_beams(const Unknowns& unknowns, const Linearization& at, double radius);

  Workers workers_;
  Layout layout_;
  std::vector<PriorMean> prior_means_;  // of the layout's blocks
  double robust_scale_sigma_ = 0.0;
  std::vector<ViewData> views_;
  std::vector<ViewBlockOptions> view_options_;
  std::vector<std::vector<int>> local_columns_;  // of each view's expanded() columns, -1: not free
  std::vector<PoseViews> poses_;

  std::vector<ViewDots> dots_;
  std::vector<std::vector<int>> dot_columns_;  // as local_columns_
  std::vector<int> beams_;                     // that take part
  std::vector<int> number_of_beam_;            // position in beams_, of each beam of the state
  std::vector<std::optional<BeamPrior>> beam_priors_;
  BlockSystem pattern_;  // all zero
  std::optional<Elimination<6, 4>> poses_first_;
  std::optional<Elimination<4, 6>> beams_first_;

  std::vector<int> refusals_;
};

}  // namespace raybundle
