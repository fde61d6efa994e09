// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/initialize/camera_start.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>

#include "lens_search.hpp"
#include "linear_pose.hpp"
#include "model_fit.hpp"
#include "parallel_boards.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/threads.hpp"
#include "view_pose.hpp"
#include "view_screen.hpp"

namespace raybundle {
namespace {

constexpr double kFit_px = 3.0;             ///< a corner fits a good lens within this
constexpr std::size_t kSearchViews = 16;    ///< for the sweep
constexpr std::size_t kSearchCorners = 32;  ///< of each of them
constexpr std::size_t kRefineViews = 32;    ///< for the last refinement
constexpr std::size_t kRefineCorners = 44;
constexpr double kPolished = 1e-3;        ///< of the cost: an iteration that wins less is the last one
constexpr double kShareOfViews = 0.7;     ///< a lens under which fewer views fit is looked for once more, thoroughly
constexpr double kOffAxisWeight = 100.0;  ///< of a prior: 0.01 costs as much as one corner that is off by a pixel
constexpr double kOtherFocal = 0.05;      ///< relative: lenses whose focal lengths differ by less are one
constexpr double kNearlyAsGood = 1.2;     ///< times the best score: all corners decide
constexpr double kExact_px = 0.02;        ///< no corner is measured better
constexpr std::size_t kMostLenses = 3;    ///< that all corners decide between
constexpr double kAlike_rad = 0.1;        ///< boards whose normals are within this of each other are held alike
constexpr double kPlainFocal = 0.005;     ///< relative uncertainty of a lens that no other one is like
constexpr double kMaxFocalUncertainty = 0.2;  ///< relative; what is left to chance beyond this is not a start

bool usable(const PointsInView& view) { return view.points.size() >= 4 && !principal_frame(view.points).collinear(); }

/// The views of a camera with their corners, those that a pose can be found for first.
struct CameraViews {
  std::vector<int> index;  ///< into problem.views
  std::vector<PointsInView> corners;
  std::size_t usable_views = 0;

  std::span<const PointsInView> usable() const { return std::span(corners).first(usable_views); }
};

CameraViews views_of(const CalibrationProblem& problem, int camera) {
  CameraViews views, unusable;
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    if (problem.views[v].camera != camera) continue;
    PointsInView corners = points_in_view(problem.targets[problem.views[v].target], problem.views[v]);
    CameraViews& among = usable(corners) ? views : unusable;
    among.index.push_back(static_cast<int>(v));
    among.corners.push_back(std::move(corners));
  }
  views.usable_views = views.corners.size();
  std::ranges::copy(unusable.index, std::back_inserter(views.index));
  std::ranges::move(unusable.corners, std::back_inserter(views.corners));
  return views;
}

/// Rays of the corners that the start lens explains, and where it puts them.
PointsInView covered_field(const std::vector<PointsInView>& views, const LensGuess& guess) {
  const LensFunctions& lens = start_lens_functions();
  PointsInView samples;
  std::vector<double> distances;
  for (std::size_t v = 0; v < views.size(); ++v) {
    pixel_distances(lens, guess.parameters.data(), views[v], guess.poses[v], distances);
    for (std::size_t i = 0; i < distances.size(); ++i) {
      if (!(distances[i] < 4.0 * guess.score_px + 1.0)) continue;
      const Eigen::Vector3d ray = (guess.poses[v] * views[v].points[i]).normalized();
      Eigen::Vector2d pixel;
      if (!lens.project(guess.parameters.data(), ray, pixel)) continue;
      samples.points.push_back(ray);
      samples.pixels.push_back(pixel);
    }
  }
  return samples;
}

/// Which parameters of a lens move opposite corners the same way: those of a lens whose parts are off its axis. What
/// only bends the profile moves them in opposite directions.
std::vector<bool> off_axis_parameters(const LensFunctions& lens, const LensVector& parameters) {
  std::vector<bool> off_axis(static_cast<std::size_t>(lens.parameters), false);
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> wrt_ray;
  double here[2 * kMaxLensParameters], opposite[2 * kMaxLensParameters];
  const Eigen::Vector3d ray(0.2, 0.1, 1.0), other(-0.2, -0.1, 1.0);
  if (!lens.project_with_jacobians(parameters.data(), ray, pixel, wrt_ray, here)) return off_axis;
  if (!lens.project_with_jacobians(parameters.data(), other, pixel, wrt_ray, opposite)) return off_axis;
  for (int k = 4; k < lens.parameters; ++k) {
    const Eigen::Vector2d a(here[k], here[lens.parameters + k]), b(opposite[k], opposite[lens.parameters + k]);
    off_axis[static_cast<std::size_t>(k)] = (a - b).norm() < (a + b).norm();
  }
  return off_axis;
}

/// What is known of any lens, as weak priors: its axis meets the image near the middle, and its parts are nearly on it.
void expect_ordinary_lens(const LensFunctions& lens, ImageSize size, const LensVector& parameters,
                          LensBundleOptions& options) {
  options.prior_mean.segment<2>(2) << 0.5 * (size.width - 1), 0.5 * (size.height - 1);
  options.prior_weight.segment<2>(2).setConstant(10.0 / size.width);
  const std::vector<bool> off_axis = off_axis_parameters(lens, parameters);
  for (int k = 4; k < lens.parameters; ++k) {
    if (off_axis[static_cast<std::size_t>(k)]) options.prior_weight[k] = kOffAxisWeight;
  }
}

/// Model parameters and poses together, on views that fit; what the conversion from the start lens lost is won back.
void polish(ModelId model, ImageSize size, const std::vector<PointsInView>& views, LensGuess& guess) {
  const LensFunctions lens = lens_functions(model);
  for (int round = 0; round < 3; ++round) {
    LensBundleOptions options = model_options(model, guess.parameters, guess.loss_scale_px());
    expect_ordinary_lens(lens, size, guess.parameters, options);
    options.max_iterations = 10;
    options.last_decrease = kPolished;
    const int iterations = refine_lens(lens, views, options, guess.parameters, guess.poses).iterations;
    guess.score_px = robust_score(lens, guess.parameters.data(), views, guess.poses);
    const bool next_is_the_same = guess.loss_scale_px() > 0.98 * options.scale_px;
    if (iterations < options.max_iterations && next_is_the_same) break;
  }
}

std::vector<PointsInView> selection(std::span<const PointsInView> views, std::size_t count, std::size_t corners) {
  std::vector<PointsInView> selected;
  for (const std::size_t v : spread_views(views, count)) selected.push_back(thinned(views[v], corners));
  return selected;
}

/// A corner fits within this [px] where they are off by `usual_px`: 3 px, or more for a model that leaves large residuals
/// everywhere.
double fit_threshold(double usual_px) { return std::clamp(5.0 * usual_px, kFit_px, 50.0); }

double fit_threshold(const std::vector<std::optional<ViewPose>>& poses) {
  std::vector<double> medians;
  for (const auto& pose : poses) {
    if (pose && std::isfinite(pose->median_px)) medians.push_back(pose->median_px);
  }
  return medians.empty() ? kFit_px : fit_threshold(median(medians));
}

/// Whether nearly all boards face the same way: such views fit several lenses.
bool held_alike(const std::vector<Rigid3>& camera_from_target) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Rigid3& pose : camera_from_target) mean += pose.rotation * Eigen::Vector3d::UnitZ();
  mean.normalize();
  const auto alike = std::ranges::count_if(camera_from_target, [&](const Rigid3& pose) {
    return mean.dot(pose.rotation * Eigen::Vector3d::UnitZ()) > std::cos(kAlike_rad);
  });
  return 10 * alike >= 9 * std::ssize(camera_from_target);
}

/// Why the views leave the lens open under this guess; empty when they do not.
std::string reason_against_lens(const std::vector<PointsInView>& views, ImageSize size, const LensGuess& guess) {
  const double uncertainty = focal_uncertainty(views, size, guess);
  if (!(uncertainty < kMaxFocalUncertainty)) {
    return "the views leave the focal length open (to about " +
           std::to_string(static_cast<int>(std::min(100 * uncertainty, 999.0))) +
           " %), as boards do that are all parallel to the image; tilt the board by 20 to 45 degrees in some images";
  }
  if (all_parallel_to_image(views, guess.score_px)) {
    return "the board is parallel to the image in all views, so that focal length and distance cannot be told "
           "apart; tilt the board by 20 to 45 degrees in some images";
  }
  return {};
}

/// The start lens's rays in the model asked for, on the views that it was found with.
LensGuess lens_in_model(ModelId model, ImageSize size, const std::vector<PointsInView>& chosen,
                        const LensGuess& start) {
  const PointsInView field = covered_field(chosen, start);
  const auto polished = [&](const LensVector& fit) {
    LensGuess guess{fit, start.poses, 0.0};
    guess.score_px = robust_score(lens_functions(model), fit.data(), chosen, guess.poses);
    polish(model, size, chosen, guess);
    return guess;
  };
  LensGuess best = polished(fit_model(model, field, start.parameters));
  const bool fits_as_well = best.score_px <= std::max(kNearlyAsGood * start.score_px, kExact_px);
  if (fits_as_well || best.parameters.size() == 4) return best;
  // Some shapes hold a fit fast, like the one at which the derivative by a field of view's w vanishes.
  for (const LensVector& fit : model_fits(model, field, best.parameters)) {
    LensGuess other = polished(fit);
    if (other.score_px < best.score_px) best = std::move(other);
  }
  return best;
}

/// What the views make of several start lenses, the best first, in the model asked for: those that differ and are
/// nearly as good as the best, which comes first.
std::vector<LensGuess> lenses_in_model(const ProblemCamera& camera, const std::vector<PointsInView>& chosen,
                                       const std::vector<LensGuess>& starts) {
  std::vector<LensGuess> lenses;
  std::string best_open;  // why the best start leaves the lens open
  for (const LensGuess& start : starts) {
    // Where it does, one that fits plainly worse does not close it.
    if (!best_open.empty() && start.score_px > kNearlyAsGood * starts.front().score_px) break;
    const std::string reason = reason_against_lens(chosen, camera.size, start);
    if (reason.empty()) lenses.push_back(lens_in_model(camera.model, camera.size, chosen, start));
    if (&start == &starts.front()) best_open = reason;
  }
  if (lenses.empty()) throw Error(ErrorKind::kNotEnoughData, best_open, "camera " + camera.name);
  std::ranges::stable_sort(lenses, {}, &LensGuess::score_px);
  const auto focal_px = [&](const LensGuess& lens) {
    return focal_on_axis_px({camera.model, camera.size, lens.parameters});
  };
  std::vector<LensGuess> kept;
  for (const LensGuess& lens : lenses) {
    const double focal = focal_px(lens);
    const bool known = std::ranges::any_of(kept, [&](const LensGuess& other) {
      const double of_other = focal_px(other);
      return std::abs(focal - of_other) <= kOtherFocal * std::max(focal, of_other);
    });
    if (!known && lens.score_px <= kNearlyAsGood * lenses.front().score_px) kept.push_back(lens);
  }
  if (kept.size() > kMostLenses) kept.resize(kMostLenses);
  return kept;
}

/// A lens on more views, those that fit it.
LensVector lens_on_more(ModelId model, ImageSize size, std::span<const PointsInView> views, const LensGuess& guess) {
  const LensFunctions lens = lens_functions(model);
  const double threshold = fit_threshold(guess.score_px);
  LensGuess last;
  last.parameters = guess.parameters;
  std::vector<PointsInView> fitting;
  for (const PointsInView& view : selection(views, kRefineViews, kRefineCorners)) {
    const auto pose = view_pose(lens, guess.parameters.data(), view, threshold);
    if (!reason_against(pose, view, threshold).empty()) continue;
    fitting.push_back(view);
    last.poses.push_back(pose->camera_from_target);
  }
  if (fitting.size() < 3) return guess.parameters;
  last.score_px = robust_score(lens, last.parameters.data(), fitting, last.poses);
  polish(model, size, fitting, last);
  return last.parameters;
}

/// What a lens makes of the views.
struct PosedViews {
  LensVector lens;
  std::vector<std::optional<ViewPose>> poses;
  double threshold_px = kFit_px;
  std::vector<std::string> reasons;  ///< why a view has no pose; empty where it has one

  std::size_t posed() const { return static_cast<std::size_t>(std::ranges::count(reasons, std::string())); }
};

/// Poses of all views under a lens; the threshold follows how well the lens fits.
PosedViews posed_views(ModelId model, const LensVector& parameters, const CameraViews& views, int threads) {
  const LensFunctions lens = lens_functions(model);
  PosedViews posed;
  posed.lens = parameters;
  posed.poses.resize(views.corners.size());
  posed.reasons.resize(views.corners.size());
  for_each_index(views.usable_views, threads, [&](std::size_t i) {
    posed.poses[i] = view_pose(lens, parameters.data(), views.corners[i], 2 * kFit_px);
  });
  posed.threshold_px = fit_threshold(posed.poses);
  std::vector<std::size_t> unfit;
  for (std::size_t i = 0; i < views.usable_views; ++i) {
    std::optional<ViewPose>& pose = posed.poses[i];
    if (pose) judge(*pose, posed.threshold_px);
    if (!(pose && pose->fits())) unfit.push_back(i);
  }
  for_each_index(unfit.size(), threads, [&](std::size_t k) {
    const std::size_t i = unfit[k];
    posed.poses[i] = ransac_view_pose(lens, parameters.data(), views.corners[i], posed.threshold_px);
  });
  for (std::size_t i = 0; i < views.corners.size(); ++i) {
    posed.reasons[i] = reason_against(posed.poses[i], views.corners[i], posed.threshold_px);
  }
  return posed;
}

std::vector<PosedViews> only(PosedViews&& posed) {
  std::vector<PosedViews> one;
  one.push_back(std::move(posed));
  return one;
}

/// Lens and poses from the views alone, in the model asked for; of lenses that are nearly as good, the best first.
std::vector<PosedViews> find_lenses(const ProblemCamera& camera, const CameraViews& all, int threads) {
  const std::span<const PointsInView> views = all.usable();
  if (views.size() < 3) {
    const std::string usable = std::to_string(views.size()), count = std::to_string(all.corners.size());
    const std::string few =
        views.size() < all.corners.size()
            ? "only " + usable + " of " + count + " views show four corners or more that do not lie on one line"
        : views.empty()
            ? "there is no view of the board"
            : "there " + std::string(views.size() == 1 ? "is only 1 view" : "are only 2 views") + " of the board";
    throw Error(ErrorKind::kNotEnoughData, few + ", and a lens needs three; take more images of the board",
                "camera " + camera.name);
  }
  const std::vector<PointsInView> chosen = screened(views, spread_views(views, kSearchViews), kSearchCorners);

  std::optional<PosedViews> quick;
  // A quick answer counts only where it can be tested, on views that it was not found with, which it fits plainly, and
  // not where several lenses may fit: of boards that are far away or held alike.
  const auto first = views.size() > chosen.size() ? search_lens_quickly(chosen, camera.size) : std::nullopt;
  if (first && !held_alike(first->poses) && focal_uncertainty(chosen, camera.size, *first) < kPlainFocal) {
    const LensGuess in_model = lens_in_model(camera.model, camera.size, chosen, *first);
    const auto enough = [&] {
      const bool fits_plainly = quick->threshold_px <= kFit_px;
      return fits_plainly && static_cast<double>(quick->posed()) >= kShareOfViews * static_cast<double>(views.size());
    };
    quick = posed_views(camera.model, in_model.parameters, all, threads);
    if (enough()) return only(std::move(*quick));
    quick = posed_views(camera.model, lens_on_more(camera.model, camera.size, views, in_model), all, threads);
    if (enough()) return only(std::move(*quick));
  }
  std::vector<PosedViews> found;
  for (const LensGuess& lens : lenses_in_model(camera, chosen, search_lenses(chosen, camera.size))) {
    found.push_back(posed_views(camera.model, lens_on_more(camera.model, camera.size, views, lens), all, threads));
  }
  if (quick && quick->posed() > found.front().posed()) found.insert(found.begin(), *quick);
  return found;
}

CameraStart start_of(const CalibrationProblem& problem, const ProblemCamera& camera, const CameraViews& views,
                     const PosedViews& posed) {
  CameraStart start;
  start.camera = {camera.model, camera.size, posed.lens};
  start.camera_from_target.resize(problem.views.size());
  start.reasons.resize(problem.views.size());
  for (std::size_t i = 0; i < views.index.size(); ++i) {
    const int v = views.index[i];
    start.reasons[v] = posed.reasons[i];
    if (start.reasons[v].empty()) start.camera_from_target[v] = posed.poses[i]->camera_from_target;
  }
  return start;
}

}  // namespace

CameraStart initialize_camera(const CalibrationProblem& problem, int camera, int threads) {
  const ProblemCamera& wanted = problem.cameras[camera];
  const CameraViews views = views_of(problem, camera);
  if (wanted.parameters) {
    return start_of(problem, wanted, views, posed_views(wanted.model, *wanted.parameters, views, threads));
  }
  const std::vector<PosedViews> found = find_lenses(wanted, views, threads);
  CameraStart best = start_of(problem, wanted, views, found.front());
  for (std::size_t i = 1; i < found.size(); ++i) best.others.push_back(start_of(problem, wanted, views, found[i]));
  return best;
}

std::optional<Rigid3> initialize_view(const CalibrationProblem& problem, const TargetView& view, const Camera& camera,
                                      std::string& reason, double fit_px) {
  const PointsInView corners = points_in_view(problem.targets[view.target], view);
  const LensFunctions lens = lens_functions(camera.model);
  std::optional<ViewPose> pose;
  if (usable(corners)) pose = view_pose(lens, camera.parameters.data(), corners, fit_px);
  reason = reason_against(pose, corners, fit_px);
  if (!reason.empty()) return std::nullopt;
  return pose->camera_from_target;
}

}  // namespace raybundle
