// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "raybundle/scene/problem.hpp"
#include "raybundle/scene/result.hpp"
#include "raybundle/uncertainty/requirements.hpp"

namespace raybundle {

/// Marginal: the requirement is met, but by less than a fifth, or something speaks against relying on it. Of rms and
/// coverage, which are counted and not estimated, any margin will do.
enum class Grade { kPass, kMarginal, kFail };

/// "pass", "marginal", "fail"
const char* grade_name(Grade grade);

/// Standard deviation [m] of a camera's distance from the first one, by the noise of the corners or by how the frames
/// scatter, whichever is larger; 0 when it was held fixed.
double baseline_sigma(const RigCamera& camera, const Calibration& calibration);

/// What became of a requirement for one camera, or for two together.
struct Judgement {
  Requirement requirement;
  std::string subject;
  Grade grade = Grade::kFail;
  double value = 0.0;  ///< in the quantity's unit; NaN: it cannot be told
  std::string reason;  ///< what was found, a clause
  std::string advice;  ///< what to do; empty when nothing has to be done
};

/// Something that is good to know of the data, whatever is required.
struct Finding {
  std::string subject;  ///< camera, board, the rig or the data
  std::string topic;    ///< lens, image, field, angle, square, tilt, ..., as docs/formats/gates.md explains them
  bool good = true;
  std::string text;    ///< one clause, with figures
  std::string advice;  ///< empty when it is good
};

struct Verdict {
  std::optional<Grade> grade;  ///< the worst of the judgements; nothing when nothing was required
  std::vector<Judgement> judgements;
  std::vector<Finding> findings;
};

/// Holds a result against requirements, and says what its data lack. What cannot be judged fails. Where the calibration
/// has a covariance by frames, the worse of both counts.
Verdict verdict(const CalibrationProblem& problem, const CalibrationResult& result,
                const std::vector<Requirement>& requirements);

}  // namespace raybundle
