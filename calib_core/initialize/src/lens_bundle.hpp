// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "lens_functions.hpp"
#include "raybundle/geometry/quantile.hpp"

namespace raybundle {

struct LensBundleOptions {
  double scale_px = 3.0;  ///< of the Geman-McClure loss: corners far beyond have no pull, unprojectable ones neither
  int max_iterations = 20;
  double last_decrease = 1e-4;  ///< of the cost: an iteration that lowers it by less is the last one
  bool poses_fixed = false;
  bool lens_fixed = false;
  bool with_information = false;  ///< fill LensBundleSummary::information
  LensVector prior_mean;          ///< empty: no priors
  LensVector prior_weight;        ///< 1 / sigma of each parameter in units of 1 px of residual; 0: free
  double aspect_weight = 0.0;     ///< 1 / sigma of fy / fx - 1
  std::vector<int> held;          ///< indices of parameters that keep their value
};

struct LensBundleSummary {
  double cost = 0.0;  ///< robust, [px²], priors included
  int iterations = 0;
  LensMatrix information;  ///< when asked for: about the parameters, poses eliminated, without the priors
};

/// Robust Levenberg-Marquardt over a lens and its board poses, in place; poses eliminated by Schur complement. Small
/// and dense: it only has to bring a start into the basin of the real bundle.
LensBundleSummary refine_lens(const LensFunctions& lens, const std::vector<PointsInView>& views,
                              const LensBundleOptions& options, LensVector& parameters, std::vector<Rigid3>& poses);

/// Distances [px] of a view's corners from where the lens puts them; infinite where it does not project them.
void pixel_distances(const LensFunctions& lens, const double* parameters, const PointsInView& view, const Rigid3& pose,
                     std::vector<double>& distances_px);

}  // namespace raybundle
