// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/structured_light/labels.hpp"

namespace raybundle {

/// Two candidates exclude each other: of one dot, of one beam, or out of order.
inline bool exclude(const LabelTask& task, const Candidate& a, const Candidate& b) {
  return a.dot == b.dot || a.beam == b.beam || !in_order(task, a, b);
}

/// Log-odds that two neighbouring beams hit at these inverse distances because they hit one surface, against by chance.
double smoothness(double inverse_distance_a, double inverse_distance_b, const SensorRange& range);

/// The best smoothness of a candidate beside the chosen candidates of its beam's neighbours; 0 when none has a label.
double support_by_neighbours(const LabelTask& task, const LabelWork& work, const Candidate& candidate);

/// Begins with no dot labelled and all candidates alive.
void begin(const LabelTask& task, LabelWork& work);

/// Gives a dot its label.
void choose(const LabelTask& task, LabelWork& work, int candidate);

/// Takes it back.
void withdraw(const LabelTask& task, LabelWork& work, int dot);

/// By how much [log-odds] a label must outdo every rival: one error in a hundred doubtful cases.
inline constexpr double kSureBy = 4.6;

}  // namespace raybundle
