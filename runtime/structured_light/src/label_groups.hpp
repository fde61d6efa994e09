// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/structured_light/labels.hpp"

namespace raybundle {

/// What a set of labels is worth.
struct SetValue {
  double of_label = 0.0;   ///< each
  double of_weight = 0.0;  ///< times weight_of() each
  double sure_by = 0.0;    ///< a dot is labelled when no set that labels it otherwise is as good but for this
};

/// The trustworthy labels, then, for every group of the other dots that are linked by common beams, the set of labels
/// of the greatest value: exact, by branch and bound over the dots. The compatibilities of labels are many, but their
/// exclusions few, so that groups are small; one whose search does not end within bounds stays unlabelled. Again, as
/// long as what the best sets agree on rules out candidates of the rest and bears out others.
void choose_best_sets(const LabelTask& task, LabelWork& work, const SetValue& value);

}  // namespace raybundle
