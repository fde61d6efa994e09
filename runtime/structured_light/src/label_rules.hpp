// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/structured_light/labels.hpp"

namespace raybundle {

/// How well two candidates of neighbouring beams fit to one surface.
struct SurfaceFit {
  double misfit = 0.0;  ///< difference of their inverse distances over what slopes make of it
  double spread = 1.0;  ///< what slopes make of it [1/m]
};

/// @param angle_rad  between the beams
SurfaceFit surface_fit(const SensorRange& range, const Candidate& a, const Candidate& b, double angle_rad);

/// Log-odds that the beams hit one surface, against that the candidates are there by chance.
double smoothness(const SensorRange& range, const SurfaceFit& fit);

/// The smoothness of a candidate beside the labels of its beam's neighbours, summed over the three that fit best; 0
/// when none has a label.
double support_by_neighbours(const LabelTask& task, const LabelWork& work, const Candidate& candidate);

/// Begins with no dot labelled and all candidates alive.
void begin(const LabelTask& task, LabelWork& work);

/// Gives a dot its label.
void choose(const LabelTask& task, LabelWork& work, int candidate);

/// Takes it back.
void withdraw(const LabelTask& task, LabelWork& work, int dot);

/// Log-odds of a candidate by its distance from the curve and by the labels of its neighbours.
inline double weight_of(const LabelTask& task, const LabelWork& work, const Candidate& candidate) {
  return candidate.log_odds + support_by_neighbours(task, work, candidate);
}

/// Fills first_of_beam and of_beam.
void index_by_beam(const LabelTask& task, LabelWork& work);

/// Labels the dots with one candidate whose beam is no candidate of another dot: the trustworthy ones.
void choose_unrivalled(const LabelTask& task, LabelWork& work);

/// Ends the life of candidates of unlabelled dots that a label excludes: of the same beam, or out of order with it.
void rule_out(const LabelTask& task, LabelWork& work);

/// Log-odds of a dot near a beam's curve, before it is looked at: beams make a hundred times as many dots there as
/// anything else does.
inline constexpr double kBeamOverClutter = 4.6;

/// By how much [log-odds] a label must outdo every rival: one error in a thousand doubtful cases.
inline constexpr double kSureBy = 7.0;

}  // namespace raybundle
