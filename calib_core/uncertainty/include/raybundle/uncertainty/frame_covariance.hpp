// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "raybundle/bundle/information.hpp"

namespace raybundle {

/// Fewer frames tell nothing about how they disagree.
inline constexpr int kFewestFrames = 10;

/// Covariance from how the frames disagree about the parameters, whatever makes the corners of a frame err together: a
/// board that is not as flat as it was taken for, blur, a lens model that does not fit. The plain covariance takes
/// every corner for an independent witness.
///
/// It has the right expectation when the corners are independent after all, but is good to some 1 / sqrt(2 frames)
/// only. Directions that one frame alone determines, and priors, keep their plain variance.
///
/// Frames are independent witnesses, unless they repeat each other.
///
/// @param repeated  of repeated_errors()
/// @return  names as `all`; nothing for fewer than kFewestFrames or when the data does not see a direction at all
/// Source: Bell and McCaffrey 2002, Bias reduction in standard errors for linear regression with multi-stage samples
///         (the cluster-robust sandwich known as CR2).
std::optional<Covariance> covariance_by_frame(const ReducedInformation& all,
                                              const std::vector<FrameInformation>& frames,
                                              const std::optional<Eigen::MatrixXd>& repeated = {}, int threads = 1);

/// A sigma by the noise of the corners or by how the frames scatter, whichever is larger.
///
/// @param sigma_by  the sigma that one covariance gives
double larger_sigma(const Calibration& calibration, const std::function<double(const Covariance&)>& sigma_by);

/// A parameter that the frames disagree about by more than its sigma says.
struct FrameScatter {
  std::string name;
  double ratio = 1.0;  ///< of the sigma by frames over the plain one
};

/// Sigmas by frames over the plain ones, largest first.
std::vector<FrameScatter> frame_scatter(const Covariance& plain, const Covariance& by_frame);

/// Ratio beyond which chance does not explain that frames disagree: three standard deviations, at least 1.3.
double material_ratio(int frames);

/// What a person should know when sigmas are materially too small; nothing otherwise.
std::optional<std::string> frame_scatter_warning(const Covariance& plain, const Covariance& by_frame, int frames);

}  // namespace raybundle
