// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "raybundle/bundle/information.hpp"
#include "raybundle/scene/result.hpp"

namespace raybundle {

/// How far frames repeat each other. Two frames that show each corner in the same place of the image, that is within a
/// cell of CornerEvidence (a sixteenth of the image's longer side), meet the same errors of board, lens and detector
/// again; how much of the errors that is, the correlation of their residuals tells.
struct FrameRepetition {
  int frames = 0;            ///< board poses in use
  int pairs = 0;             ///< of frames that show the board in the same place
  double correlation = 0.0;  ///< of the errors of a corner in both frames of a pair; 0 when chance explains it
  double worth = 0.0;        ///< as many frames in places of their own would tell as much
};

FrameRepetition frame_repetition(const CalibrationProblem& problem, const CalibrationResult& result);

/// What errors that frames share add to the covariance of the gradient of half of chi2, for residuals of unit variance:
/// for covariance_by_frame().
///
/// @param names  of ReducedInformation
/// @return       nothing when no frame repeats another one
std::optional<Eigen::MatrixXd> repeated_errors(const CalibrationProblem& problem, const BundleState& state,
                                               const std::vector<std::string>& names, int threads = 1);

}  // namespace raybundle
