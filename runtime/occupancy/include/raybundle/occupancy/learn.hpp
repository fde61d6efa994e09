// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "raybundle/occupancy/case_base.hpp"

namespace raybundle {

/// Situations whose class is known.
struct LabelledCases {
  std::string attribute_set;
  std::vector<SituationClass> situations;
  std::vector<std::string> group_names;
  Eigen::MatrixXd attributes;         ///< D×N
  std::vector<std::uint8_t> classes;  ///< N
  std::vector<AirbagAction> actions;  ///< N, what is right for each
};

struct LearnOptions {
  int neighbours = 15;
  double known_share = 0.999;      ///< of the learnt cases that are near enough to the others: sets `farthest`
  double metric_shrinkage = 0.05;  ///< of the scatter within classes towards its diagonal
  int metric_size = 20;            ///< dimensions of the metric's space, at most
  int metric_steps = 400;          ///< of the search for the metric
  double metric_decay = 1e-3;      ///< how much the metric is drawn to zero in a step
};

/// Makes a base of cases. The metric starts from the directions that tell classes apart in the space where the scatter
/// within classes is white, and is then turned so that neighbours are of one class. Not for the device: it uses the
/// heap.
///
/// @throws Error(kNotEnoughData) when a class has fewer cases than neighbours; Error(kBadInput) when sizes differ
/// Source: Bar-Hillel, Hertz, Shental, Weinshall 2005 (relevant component analysis), with shrinkage;
/// neighbourhood_metric.hpp
CaseBase learn(const LabelledCases& cases, const LearnOptions& options = {});

}  // namespace raybundle
