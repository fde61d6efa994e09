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
  std::vector<std::string> class_names;
  Eigen::MatrixXd attributes;         ///< D×N
  std::vector<std::uint8_t> classes;  ///< N
};

struct LearnOptions {
  int neighbours = 7;
  double least_share = 0.6;        ///< of the votes
  double known_share = 0.998;      ///< of the learnt cases that are near enough to the others: sets `farthest`
  double metric_shrinkage = 0.05;  ///< of the scatter within classes towards its diagonal
};

/// Makes a base of cases: the metric whitens the scatter within classes, so that what varies within every class counts
/// little. Not for the device: it uses the heap.
///
/// @throws Error(kNotEnoughData) when a class has fewer cases than neighbours; Error(kBadInput) when sizes differ
/// Source: Bar-Hillel, Hertz, Shental, Weinshall 2005 (relevant component analysis), with shrinkage
CaseBase learn(const LabelledCases& cases, const LearnOptions& options = {});

}  // namespace raybundle
