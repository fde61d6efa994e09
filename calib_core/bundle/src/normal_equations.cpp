// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "normal_equations.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <atomic>
#include <map>
#include <utility>

#include "view_data.hpp"
#include "view_rows.hpp"

namespace raybundle {
namespace {

using Kind = ParameterBlock::Kind;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Rows6 = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>;

constexpr int kMostChunks = 64;  // of poses that are summed up apart: enough for the threads, few enough for the memory

// rows become U⁻ᵀ rows.
void solve_forward(const Matrix6& upper, Rows6& rows) {
  for (int r = 0; r < 6; ++r) {
    for (int s = 0; s < r; ++s) rows.row(r) -= upper(s, r) * rows.row(s);
    rows.row(r) /= upper(r, r);
  }
}

// Upper triangle of matrix -= rowsᵀ rows.
void subtract_gram(const Rows6& rows, Eigen::Ref<Eigen::MatrixXd> matrix) {
  for (Eigen::Index b = 0; b < matrix.cols(); ++b) {
    auto column = matrix.col(b).head(b + 1);
    for (int r = 0; r < 6; ++r) column -= rows(r, b) * rows.row(r).head(b + 1).transpose();
  }
}

PriorMean values_of(const Unknowns& unknowns, const ParameterBlock& block) {
  switch (block.kind) {
    case Kind::kIntrinsics:
      return {.values = unknowns.intrinsics[block.owner], .camera_from_rig = {}};
    case Kind::kCameraFromRig:
      return {.values = {}, .camera_from_rig = unknowns.camera_from_rig[block.owner]};
    case Kind::kShape:
      break;
  }
  return {.values = unknowns.shapes[block.owner], .camera_from_rig = {}};
}

}  // namespace

void add_products(const Eigen::MatrixXd& products, const std::vector<int>& columns, Eigen::MatrixXd& local) {
  for (std::size_t b = 0; b < columns.size(); ++b) {
    for (std::size_t a = 0; a <= b && columns[b] >= 0; ++a) {
      if (columns[a] >= 0) local(std::min(columns[a], columns[b]), std::max(columns[a], columns[b])) += products(a, b);
    }
  }
}

// How a pose follows the parameters.
struct NormalEquations::EliminatedPose {
  Matrix6 upper;  // U, with UᵀU the pose's own damped equations
  Rows6 follow;   // U⁻ᵀ times its equations with its columns, then its gradient
  Vector6 damping;

  Vector6 motion(const Eigen::VectorXd& parameters_step, const std::vector<int>& columns) const {
    Vector6 right = -follow.rightCols<1>();
    for (std::size_t c = 0; c < columns.size(); ++c) right -= parameters_step[columns[c]] * follow.col(c);
    return upper.triangularView<Eigen::Upper>().solve(right);
  }
};

// Normal equations of the layout's parameters, or of some poses' part in them; upper triangle.
struct NormalEquations::Reduced {
  Eigen::MatrixXd matrix;    // after the elimination
  Eigen::VectorXd gradient;  // after the elimination
  Eigen::VectorXd diagonal;  // before it
  double decrease = 0.0;     // twice what the poses alone can take off the cost
  bool definite = true;

  explicit Reduced(int columns)
      : matrix(Eigen::MatrixXd::Zero(columns, columns)),
        gradient(Eigen::VectorXd::Zero(columns)),
        diagonal(Eigen::VectorXd::Zero(columns)) {}

  void operator+=(const Reduced& other) {
    matrix += other.matrix;
    gradient += other.gradient;
    diagonal += other.diagonal;
    decrease += other.decrease;
    definite = definite && other.definite;
  }
};

NormalEquations::NormalEquations(const CalibrationProblem& problem, const BundleState& state,
                                 const BundleOptions& options)
    : workers_(options.threads),
      layout_(estimated_blocks(problem, state, options)),
      robust_scale_sigma_(options.robust_scale_sigma),
      views_(used_views(problem, state, workers_)),
      dots_(used_dots(problem, state)),
      beam_priors_(options.beam_priors),
      refusals_(problem.views.size(), 0) {
  for (const ParameterBlock& block : layout_.blocks) prior_means_.push_back(prior_mean(problem, state, block));
  for (const ViewData& view : views_) {
    view_options_.push_back({.with_shape = layout_.estimates_shape(view.target),
                             .robust_scale_sigma = options.robust_scale_sigma,
                             .lens_fixed = !layout_.estimates_lens(view.camera)});
  }
  group_by_pose(state.poses.size());
  number_beams(state, options);
}

std::size_t NormalEquations::residuals() const {
  std::size_t points = 0;
  for (const ViewData& view : views_) points += static_cast<std::size_t>(view.inverse_sigma.size());
  for (const ViewDots& view : dots_) points += view.dots.size();
  return 2 * points;
}

// Columns of the layout for each column of expanded(), -1 for those that it does not have.
std::vector<int> NormalEquations::columns_of(int camera, int target, bool lens_fixed) const {
  std::vector<int> columns = lens_fixed ? std::vector<int>() : layout_.columns_of(Kind::kIntrinsics, camera);
  const auto append = [&](const std::vector<int>& more) { columns.insert(columns.end(), more.begin(), more.end()); };
  append(std::vector<int>(6, -1));
  if (layout_.estimates_shape(target)) append(layout_.columns_of(Kind::kShape, target));
  append({-1});
  if (camera != 0) append(layout_.columns_of(Kind::kCameraFromRig, camera));
  return columns;
}

// The same in the local equations of a pose.
std::vector<int> NormalEquations::local_columns(const PoseViews& group, int camera, int target, bool lens_fixed) const {
  std::vector<int> local = columns_of(camera, target, lens_fixed);
  for (int& column : local) {
    if (column >= 0)
      column = 6 + static_cast<int>(std::ranges::lower_bound(group.columns, column) - group.columns.begin());
  }
  const auto motion = lens_fixed ? 0 : layout_.columns_of(Kind::kIntrinsics, camera).size();
  for (int k = 0; k < 6; ++k) local[motion + k] = k;
  local[motion + 6 + (layout_.estimates_shape(target) ? 3 : 0)] = 6 + static_cast<int>(group.columns.size());
  return local;
}

void NormalEquations::group_by_pose(std::size_t poses) {
  std::vector<int> group_of_pose(poses, -1);
  std::map<std::pair<int, int>, std::vector<int>> columns;  // of the layout, by camera and target
  const auto group_with = [&](int pose, int camera, int target) -> PoseViews& {
    int& group = group_of_pose[pose];
    if (group < 0) {
      group = static_cast<int>(poses_.size());
      poses_.push_back({.pose = pose, .views = {}, .dots = {}, .columns = {}});
    }
    const auto [of_both, is_new] = columns.try_emplace({camera, target});
    if (is_new) {
      of_both->second = columns_of(camera, target);
      std::erase(of_both->second, -1);
    }
    std::ranges::copy(of_both->second, std::back_inserter(poses_[group].columns));
    return poses_[group];
  };
  for (int v = 0; v < static_cast<int>(views_.size()); ++v) {
    group_with(views_[v].pose, views_[v].camera, views_[v].target).views.push_back(v);
  }
  for (int v = 0; v < static_cast<int>(dots_.size()); ++v) {
    group_with(dots_[v].pose, dots_[v].camera, dots_[v].target).dots.push_back(v);
  }
  local_columns_.resize(views_.size());
  dot_columns_.resize(dots_.size());
  workers_.for_each(static_cast<int>(poses_.size()), [&](int p) {
    PoseViews& group = poses_[p];
    std::ranges::sort(group.columns);
    group.columns.erase(std::unique(group.columns.begin(), group.columns.end()), group.columns.end());
    group.columns.shrink_to_fit();
    for (int v : group.views) {
      local_columns_[v] = local_columns(group, views_[v].camera, views_[v].target, view_options_[v].lens_fixed);
    }
    for (int v : group.dots) dot_columns_[v] = local_columns(group, dots_[v].camera, dots_[v].target);
  });
}

std::vector<PriorResidual> NormalEquations::prior_residuals(const Unknowns& unknowns) const {
  std::vector<PriorResidual> residuals;
  for (std::size_t b = 0; b < layout_.blocks.size(); ++b) {
    const ParameterBlock& block = layout_.blocks[b];
    residuals.push_back(prior_residual(block, prior_means_[b], values_of(unknowns, block)));
  }
  return residuals;
}

std::optional<double> NormalEquations::cost(const Unknowns& unknowns) {
  if (!beams_.empty()) {  // the cost of dots has no shorter way than their equations
    Linearization at;
    return linearize(unknowns, at) ? std::optional(at.cost) : std::nullopt;
  }
  std::vector<std::optional<double>> of_views(views_.size());
  workers_.for_each(static_cast<int>(views_.size()),
                    [&](int v) { of_views[v] = view_chi2(views_[v], unknowns.at(views_[v]), view_options_[v]); });
  double chi2 = 0.0;
  for (const std::optional<double>& of_view : of_views) {
    if (!of_view) return std::nullopt;
    chi2 += *of_view;
  }
  for (const PriorResidual& prior : prior_residuals(unknowns)) chi2 += prior.residual.squaredNorm();
  return 0.5 * chi2;
}

bool NormalEquations::linearize(const Unknowns& unknowns, Linearization& result) {
  result.views.resize(views_.size());
  std::atomic<bool> projectable = true;
  workers_.for_each(static_cast<int>(views_.size()), [&](int v) {
    if (accumulate_view(views_[v], unknowns.at(views_[v]), view_options_[v], result.views[v])) return;
    ++refusals_[views_[v].view];
    projectable = false;
  });
  double chi2 = 0.0;
  for (const ViewNormal& view : result.views) chi2 += view.chi2;
  result.priors = prior_residuals(unknowns);
  for (const PriorResidual& prior : result.priors) chi2 += prior.residual.squaredNorm();
  bool dots_projectable = projectable;
  if (!beams_.empty()) chi2 += assemble(unknowns, result, dots_projectable);
  result.cost = 0.5 * chi2;
  return projectable && dots_projectable;
}

void NormalEquations::fill_local_equations(const PoseViews& group, const Unknowns& unknowns, const Linearization& at,
                                           Eigen::MatrixXd& local) const {
  const auto size = static_cast<Eigen::Index>(6 + group.columns.size() + 1);
  local.setZero(size, size);
  for (int v : group.views) {
    const std::vector<int>& columns = local_columns_[v];
    const Eigen::MatrixXd& products = at.views[v].products;
    if (views_[v].camera == 0) {
      add_products(products, columns, local);  // its frame is the rig's
    } else {
      const Eigen::Index intrinsics = view_options_[v].lens_fixed ? 0 : unknowns.intrinsics[views_[v].camera].size();
      add_products(expanded(products, MotionMap(unknowns.at(views_[v])), intrinsics), columns, local);
    }
  }
}

bool NormalEquations::eliminate(const PoseViews& group, double radius, Eigen::MatrixXd& local, EliminatedPose& pose,
                                Reduced& reduced) const {
  const auto count = static_cast<Eigen::Index>(group.columns.size());
  Matrix6 own = local.topLeftCorner<6, 6>();
  for (int k = 0; k < 6; ++k) pose.damping[k] = damping(own(k, k), radius);
  own.diagonal() += pose.damping;
  const Eigen::LLT<Matrix6, Eigen::Upper> factor(own);
  if (factor.info() != Eigen::Success) return false;
  pose.upper = factor.matrixU();
  pose.follow = local.topRightCorner(6, count + 1);
  solve_forward(pose.upper, pose.follow);
  reduced.decrease += pose.follow.col(count).squaredNorm();
  for (Eigen::Index a = 0; a < count; ++a) reduced.diagonal[group.columns[a]] += local(6 + a, 6 + a);
  subtract_gram(pose.follow, local.bottomRightCorner(count + 1, count + 1));
  for (Eigen::Index b = 0; b < count; ++b) {
    for (Eigen::Index a = 0; a <= b; ++a) reduced.matrix(group.columns[a], group.columns[b]) += local(6 + a, 6 + b);
    reduced.gradient[group.columns[b]] += local(6 + b, 6 + count);
  }
  return true;
}

void NormalEquations::add_priors(const Linearization& at, Reduced& reduced) const {
  for (std::size_t b = 0; b < layout_.blocks.size(); ++b) {
    const PriorResidual& prior = at.priors[b];
    if (prior.residual.size() == 0) continue;
    const Eigen::MatrixXd rows = prior_rows(layout_, layout_.blocks[b], prior);
    reduced.matrix += rows.transpose() * rows;
    reduced.gradient += rows.transpose() * prior.residual;
    reduced.diagonal += rows.colwise().squaredNorm().transpose();
  }
}

std::optional<Step> NormalEquations::step(const Unknowns& unknowns, const Linearization& at, double radius) {
  if (!beams_.empty()) return step_with_beams(unknowns, at, radius);
  const int poses = static_cast<int>(poses_.size());
  const int per_chunk = (poses + kMostChunks - 1) / kMostChunks;
  const int chunks = (poses + per_chunk - 1) / per_chunk;
  std::vector<EliminatedPose> eliminated(poses);
  std::vector<Reduced> parts(chunks, Reduced(layout_.columns));
  workers_.for_each(chunks, [&](int c) {
    Eigen::MatrixXd local;
    for (int p = c * per_chunk; p < std::min((c + 1) * per_chunk, poses); ++p) {
      fill_local_equations(poses_[p], unknowns, at, local);
      if (!eliminate(poses_[p], radius, local, eliminated[p], parts[c])) parts[c].definite = false;
    }
  });
  Reduced reduced(layout_.columns);
  for (const Reduced& part : parts) reduced += part;
  add_priors(at, reduced);
  if (!reduced.definite) return {};

  const Eigen::VectorXd damped = reduced.diagonal.unaryExpr([&](double d) { return damping(d, radius); });
  reduced.matrix.diagonal() += damped;
  const Eigen::LLT<Eigen::MatrixXd, Eigen::Upper> factor(reduced.matrix);
  if (factor.info() != Eigen::Success) return {};
  Step step;
  step.parameters = -factor.solve(reduced.gradient);
  step.motions.assign(unknowns.rig_from_target.size(), Vector6::Zero());
  double damped_square = (damped.array() * step.parameters.array().square()).sum();
  std::vector<double> damped_squares(poses);
  workers_.for_each(poses, [&](int p) {
    Vector6& motion = step.motions[poses_[p].pose];
    motion = eliminated[p].motion(step.parameters, poses_[p].columns);
    damped_squares[p] = (eliminated[p].damping.array() * motion.array().square()).sum();
  });
  for (const double square : damped_squares) damped_square += square;
  // With the gradient g and the damping D: (H + D) step = -g, hence -gᵀ step - stepᵀ H step / 2 is this.
  step.predicted_decrease = 0.5 * (damped_square + reduced.decrease - reduced.gradient.dot(step.parameters));
  return step;
}

Unknowns NormalEquations::moved(const Unknowns& unknowns, const Step& step) {
  Unknowns result = unknowns;
  for (std::size_t b = 0; b < layout_.blocks.size(); ++b) {
    const ParameterBlock& block = layout_.blocks[b];
    if (layout_.free[b].empty()) continue;
    Eigen::VectorXd change = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(block.parameters.size()));
    change(layout_.free[b]) =
        step.parameters.segment(layout_.first[b], static_cast<Eigen::Index>(layout_.free[b].size()));
    if (block.kind == Kind::kIntrinsics) result.intrinsics[block.owner] += change;
    if (block.kind == Kind::kShape) result.shapes[block.owner] += change;
    if (block.kind == Kind::kCameraFromRig) {
      Rigid3& pose = result.camera_from_rig[block.owner];
      pose = perturbed(pose, change);
    }
  }
  workers_.for_each(static_cast<int>(poses_.size()), [&](int p) {
    Rigid3& pose = result.rig_from_target[poses_[p].pose];
    pose = perturbed(pose, step.motions[poses_[p].pose]);
  });
  for (std::size_t b = 0; b < beams_.size(); ++b) {
    Line3& beam = result.beams[beams_[b]];
    beam = perturbed(beam, step.beams.col(static_cast<Eigen::Index>(b)));
  }
  return result;
}

}  // namespace raybundle
