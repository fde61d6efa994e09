// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "lens_search.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "linear_pose.hpp"
#include "pose_refinement.hpp"
#include "start_lens.hpp"
#include "view_screen.hpp"

namespace raybundle {
namespace {

constexpr double kMaxDistance_px = 100.0;   ///< a corner that does not project counts like one that is this far off
constexpr std::size_t kSweepViews = 3;      ///< for the first, coarse sweep
constexpr std::size_t kQuickViews = 6;      ///< for what is best in it
constexpr std::size_t kQuickCorners = 16;   ///< of each of them
constexpr double kQuickDecrease = 0.01;     ///< of the cost: what is won afterwards, the model asked for wins too
constexpr double kGoodFitOfWidth = 1.2e-3;  ///< of the image: a lens that leaves more may be the wrong one
constexpr std::size_t kRefined = 30;        ///< guesses of the sweep
constexpr std::size_t kMostAnswers = 12;    ///< lenses that fit and differ
constexpr double kAsGood = 2.0;             ///< times the best score: the model asked for decides
constexpr int kAlpha = 4;                   ///< index of StartLens's profile in the parameters

double mean_of_best(std::vector<double>& values, double share) {
  const auto count = std::max<std::size_t>(1, static_cast<std::size_t>(share * static_cast<double>(values.size())));
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(count - 1));
  return std::accumulate(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(count), 0.0) /
         static_cast<double>(count);
}

/// Linear pose of a view under a lens without polynomial; the identity in front of the camera when there is none.
Rigid3 quick_pose(const LensVector& lens, const PointsInView& view, const PrincipalFrame& frame, int iterations) {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3d> rays;
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    const double plane[2] = {(view.pixels[i].x() - lens[2]) / lens[0], (view.pixels[i].y() - lens[3]) / lens[1]};
    Eigen::Vector3d ray;
    if (!StartLens::ray_from_plane_without_polynomial(lens[kAlpha], plane, ray.data())) continue;
    points.push_back(view.points[i]);
    rays.push_back(ray);
  }
  Rigid3 fallback;
  fallback.translation = Eigen::Vector3d(0, 0, 10.0 * frame.spread[0]) - frame.centre;
  if (points.size() < 4) return fallback;
  const bool spatial = frame.spread[2] > 0.1 * frame.spread[0] && points.size() >= 6;
  const auto pose = spatial ? linear_spatial_pose(points, rays, frame) : linear_planar_pose(points, rays, frame);
  if (!pose) return fallback;
  Rigid3 refined = *pose;
  refine_on_rays(points, rays, refined, iterations, 0.05, 1e-3);
  return refined;
}

LensGuess guess_with(double alpha, double focal, const Eigen::Vector2d& centre, const std::vector<PointsInView>& views,
                     const std::vector<PrincipalFrame>& frames, int iterations) {
  LensGuess guess;
  guess.parameters.resize(start_lens_functions().parameters);
  guess.parameters << focal, focal, centre.x(), centre.y(), alpha, 0.0, 0.0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    guess.poses.push_back(quick_pose(guess.parameters, views[v], frames[v], iterations));
  }
  guess.score_px = robust_score(start_lens_functions(), guess.parameters.data(), views, guess.poses);
  return guess;
}

/// The same lens with more views.
LensGuess posed_anew(const LensGuess& guess, const std::vector<PointsInView>& views,
                     const std::vector<PrincipalFrame>& frames, int iterations) {
  const Eigen::Vector2d centre = guess.parameters.segment<2>(2);
  return guess_with(guess.parameters[kAlpha], guess.parameters[0], centre, views, frames, iterations);
}

/// What is known of any lens before it is seen, as priors of about a pixel's weight; `bent` frees the polynomial and the
/// aspect ratio.
LensBundleOptions search_options(ImageSize size, double scale_px, bool bent) {
  LensBundleOptions options;
  options.scale_px = scale_px;
  options.prior_mean.setZero(start_lens_functions().parameters);
  options.prior_weight.setZero(start_lens_functions().parameters);
  constexpr double kHeld = 1e4;
  const double centre_weight = 10.0 / size.width;  // within a tenth of the width
  options.prior_mean.segment<2>(2) << 0.5 * (size.width - 1), 0.5 * (size.height - 1);
  options.prior_weight.segment<2>(2).setConstant(centre_weight);
  options.prior_mean[kAlpha] = 0.4;  // in the middle of rectilinear (0) and equisolid (0.7), by a third
  options.prior_weight[kAlpha] = 3.0;
  options.prior_weight.tail<2>().setConstant(bent ? 3.0 : kHeld);
  options.aspect_weight = bent ? 20.0 : kHeld;  // within 5 %
  return options;
}

/// Whether it has come to rest before the iterations were over.
bool refine(const std::vector<PointsInView>& views, ImageSize size, bool bent, int iterations, LensGuess& guess,
            double last_decrease = LensBundleOptions{}.last_decrease) {
  LensBundleOptions options = search_options(size, guess.loss_scale_px(), bent);
  options.max_iterations = iterations;
  options.last_decrease = last_decrease;
  const LensBundleSummary summary = refine_lens(start_lens_functions(), views, options, guess.parameters, guess.poses);
  guess.score_px = robust_score(start_lens_functions(), guess.parameters.data(), views, guess.poses);
  return summary.iterations < iterations;
}

/// Keeps the best guesses that are not each other's neighbours in the sweep.
std::vector<LensGuess> best_and_different(std::vector<LensGuess> guesses, std::size_t count) {
  std::ranges::stable_sort(guesses, {}, &LensGuess::score_px);
  std::vector<LensGuess> kept;
  for (const LensGuess& guess : guesses) {
    const bool near = std::ranges::any_of(kept, [&](const LensGuess& other) {
      return std::abs(std::log(guess.parameters[0] / other.parameters[0])) < 0.25 &&
             std::abs(guess.parameters[kAlpha] - other.parameters[kAlpha]) < 0.12;
    });
    if (!near) kept.push_back(guess);
    if (kept.size() == count) break;
  }
  return kept;
}

std::vector<PrincipalFrame> frames_of(const std::vector<PointsInView>& views) {
  std::vector<PrincipalFrame> frames;
  for (const PointsInView& view : views) frames.push_back(principal_frame(view.points));
  return frames;
}

/// Guesses for all profiles and all focal lengths from a tenth to two and a half times the longer side.
std::vector<LensGuess> sweep(std::initializer_list<double> alphas, double focal_step,
                             const std::vector<PointsInView>& views, const std::vector<PrincipalFrame>& frames,
                             ImageSize size, int iterations) {
  const Eigen::Vector2d centre(0.5 * (size.width - 1), 0.5 * (size.height - 1));
  const double half_width = 0.5 * std::max(size.width, size.height);
  std::vector<LensGuess> guesses;
  for (const double alpha : alphas) {
    for (double focal = 0.2; focal < 5.0; focal *= focal_step) {
      guesses.push_back(guess_with(alpha, focal * half_width, centre, views, frames, iterations));
    }
  }
  return guesses;
}

double good_fit_px(ImageSize size) { return std::min(1.0, kGoodFitOfWidth * std::max(size.width, size.height)); }

}  // namespace

double robust_score(const LensFunctions& lens, const double* parameters, const std::vector<PointsInView>& views,
                    const std::vector<Rigid3>& poses) {
  std::vector<double> of_views(views.size());
  std::vector<double> distances;
  for (std::size_t v = 0; v < views.size(); ++v) {
    pixel_distances(lens, parameters, views[v], poses[v], distances);
    for (double& distance : distances) distance = std::min(distance, kMaxDistance_px);
    of_views[v] = mean_of_best(distances, 0.8);
  }
  return mean_of_best(of_views, 0.7);
}

std::vector<LensGuess> search_lenses(const std::vector<PointsInView>& views, ImageSize size) {
  const std::vector<PrincipalFrame> frames = frames_of(views);
  std::vector<LensGuess> guesses = sweep({0.0, 0.3, 0.5, 0.6, 0.7, 0.85}, 1.25, views, frames, size, 4);
  // Few corners with wrong ones among them hardly tell which guesses are worth refining. Of pixels that are not square,
  // a wrong lens may fit better than the right one as long as they are held to be.
  guesses = best_and_different(std::move(guesses), kRefined);
  for (LensGuess& guess : guesses) {
    refine(views, size, false, 10, guess);
    for (const int iterations : {10, 15, 20}) refine(views, size, true, iterations, guess);
  }
  guesses = best_and_different(std::move(guesses), kMostAnswers);
  std::erase_if(guesses, [&](const LensGuess& guess) { return guess.score_px > kAsGood * guesses.front().score_px; });
  return guesses;
}

std::optional<LensGuess> search_lens_quickly(const std::vector<PointsInView>& views, ImageSize size) {
  const std::vector<PrincipalFrame> frames = frames_of(views);
  std::vector<PointsInView> few;
  for (std::size_t v = 0; v < std::min(kQuickViews, views.size()); ++v) {
    few.push_back(thinned(views[v], kQuickCorners));
  }
  const std::vector<PrincipalFrame> few_frames = frames_of(few);
  const std::vector<PointsInView> fewest(few.begin(), few.begin() + std::min(kSweepViews, few.size()));
  std::vector<LensGuess> guesses = sweep({0.0, 0.4, 0.65, 0.85}, 1.5, fewest, few_frames, size, 2);
  guesses = best_and_different(std::move(guesses), 3);
  for (LensGuess& guess : guesses) {
    guess = posed_anew(guess, few, few_frames, 2);
    refine(few, size, false, 8, guess, kQuickDecrease);
  }
  const double best_px = std::ranges::min_element(guesses, {}, &LensGuess::score_px)->score_px;
  std::erase_if(guesses, [&](const LensGuess& guess) { return guess.score_px > 2.0 * best_px + 1.0; });
  guesses = best_and_different(guesses, guesses.size());  // most have come to the same lens
  for (LensGuess& guess : guesses) {
    guess = posed_anew(guess, views, frames, 4);
    if (guesses.size() > 1) refine(views, size, false, 4, guess, kQuickDecrease);
  }
  LensGuess best = *std::ranges::min_element(guesses, {}, &LensGuess::score_px);
  for (int round = 0; round < 3; ++round) {
    const LensGuess before = best;
    const bool rests = refine(views, size, true, 8, best, kQuickDecrease);
    const bool next_is_the_same = rests && best.loss_scale_px() > 0.98 * before.loss_scale_px();
    if (next_is_the_same || best.score_px > 0.98 * before.score_px) break;
  }
  if (!(best.score_px <= good_fit_px(size))) return std::nullopt;
  return best;
}

double focal_uncertainty(const std::vector<PointsInView>& views, ImageSize size, const LensGuess& guess) {
  LensBundleOptions options = search_options(size, guess.loss_scale_px(), false);
  options.max_iterations = 0;
  options.with_information = true;
  LensVector parameters = guess.parameters;
  std::vector<Rigid3> poses = guess.poses;
  LensMatrix information = refine_lens(start_lens_functions(), views, options, parameters, poses).information;
  const double sigma_px = std::max(guess.score_px, 0.05);
  information /= sigma_px * sigma_px;
  LensVector weight = options.prior_weight;
  information.diagonal() += weight.cwiseAbs2();
  // fx and fy move together: the relative size is their common scale.
  const int n = start_lens_functions().parameters;
  LensMatrix reduced(n - 1, n - 1);
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxLensParameters, kMaxLensParameters> join =
      LensMatrix::Zero(n, n - 1);
  join(0, 0) = parameters[0];
  join(1, 0) = parameters[1];
  for (int k = 2; k < n; ++k) join(k, k - 1) = 1.0;
  reduced = join.transpose() * information * join;
  const LensVector scale = reduced.diagonal().cwiseMax(1e-30).cwiseSqrt().cwiseInverse();
  const LensMatrix scaled = scale.asDiagonal() * reduced * scale.asDiagonal();
  const LensVector first = scaled.ldlt().solve(LensVector::Unit(n - 1, 0));
  return std::sqrt(std::max(first[0], 0.0)) * scale[0];
}

}  // namespace raybundle
