// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "raybundle/scene/problem.hpp"
#include "raybundle/scene/result.hpp"

namespace raybundle {

/// A problem in an order that depends on what was seen alone, so that sums, choices and ties come out the same in
/// whatever order the views, their corners and the frames are handed in. Cameras and targets keep their places.
struct OrderedProblem {
  CalibrationProblem problem;
  std::vector<int> frames;  ///< index in the given problem of each frame
  std::vector<int> views;   ///< index in the given problem of each view
  /// Index in the given view of each of a view's observations; empty where they are as given.
  std::vector<std::vector<int>> observations;
  std::vector<std::vector<int>> dots;  ///< the same of its dots
};

/// Corners by point id, dots by pixel, views by their corners, frames by their first view.
OrderedProblem in_order_of_content(const CalibrationProblem& given);

/// The result of the ordered problem as one of the given problem.
CalibrationResult in_given_order(const OrderedProblem& ordered, CalibrationResult result);

}  // namespace raybundle
